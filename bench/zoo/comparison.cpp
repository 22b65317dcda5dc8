// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/comparison.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "bench/zoo/format.h"
#include "bench/zoo/report.h"

namespace encage::zoo {

using Json = nlohmann::ordered_json;

namespace {

std::string excess_text(const Model& model, const std::vector<std::int64_t>& faces, std::size_t target) {
  const std::optional<double> ratio = volume_ratio(level_for(model, faces, target));
  return ratio ? text("%.4f", *ratio - 1) : "–";
}

/// What is known of the file, whoever found out.
const Model& witness(const std::vector<Contender>& contenders, std::size_t file) {
  for (const Contender& contender : contenders) {
    if (contender.models[file].outcome == Model::Outcome::baked) return contender.models[file];
  }
  return contenders.front().models[file];
}

std::string row(const std::vector<Contender>& contenders, std::size_t file, const std::vector<std::int64_t>& faces) {
  const Model& known = witness(contenders, file);
  const Json& source = known.figures.at("source");
  std::string out = "| " + escaped(known.file.filename().string()) +
                    text(" | %lld | %s | %s |", source.at("faces").get<long long>(),
                         source.at("solid").get_ref<const std::string&>().c_str(), yes(known.clean()));
  for (const Contender& contender : contenders) {
    const Model& model = contender.models[file];
    for (std::size_t target = 0; target < faces.size(); ++target) out += " " + excess_text(model, faces, target) + " |";
    out += model.outcome == Model::Outcome::baked ? text(" %.2f |", model.cpu_seconds()) : " – |";
    out += std::string(" ") + yes(model.certified()) + " |";
  }
  return out + "\n";
}

std::string failures(const std::vector<Contender>& contenders) {
  std::string out;
  for (std::size_t file = 0; file < contenders.front().models.size(); ++file) {
    for (const Contender& contender : contenders) {
      const Model& model = contender.models[file];
      if (model.outcome == Model::Outcome::baked) continue;
      const bool refused = model.outcome == Model::Outcome::no_mesh;
      out += "| " + escaped(model.file.filename().string()) + " | " + (refused ? "all" : contender.name) + " | " +
             escaped(reason(model)) + " |\n";
      if (refused) break;
    }
  }
  return out;
}

}  // namespace

std::string comparison_head(const std::vector<std::int64_t>& faces) {
  std::string line = text("%-36s %-10s %8s", "file", "method", "CPU s");
  for (const std::int64_t target : faces) line += text("  %8lld", static_cast<long long>(target));
  return line + "  certified   (per level: volume ratio - 1)\n";
}

std::string comparison_line(const std::string& contender, const Model& model, const std::vector<std::int64_t>& faces) {
  std::string line = text("%-36s %-10s", model.file.filename().c_str(), contender.c_str());
  if (model.outcome != Model::Outcome::baked) return line + " " + reason(model) + "\n";
  line += text(" %8.2f", model.cpu_seconds());
  for (std::size_t target = 0; target < faces.size(); ++target) {
    const std::optional<double> ratio = volume_ratio(level_for(model, faces, target));
    line += text("  %8s", ratio ? text("%.4f", *ratio - 1).c_str() : "-");
  }
  return line + "  " + yes(model.certified()) + "\n";
}

std::string comparison_text(const std::vector<Contender>& contenders, const std::vector<std::int64_t>& faces) {
  std::string out;
  for (const Contender& contender : contenders) {
    if (!out.empty()) out += "\n";
    out += contender.name + "\n" + to_text(summarize(contender.models, faces));
  }
  return out;
}

Json comparison_json(const std::vector<Contender>& contenders, const std::vector<std::int64_t>& faces) {
  Json models = Json::array();
  Json summaries;
  for (const Contender& contender : contenders) {
    for (const Model& model : contender.models) {
      Json entry = to_json(model);
      entry["method"] = contender.name;
      models.push_back(std::move(entry));
    }
    summaries[contender.name] = to_json(summarize(contender.models, faces));
  }
  return {{"models", std::move(models)}, {"summaries", std::move(summaries)}};
}

std::string comparison_markdown(const std::vector<Contender>& contenders, const std::vector<std::int64_t>& faces,
                                const std::string& command) {
  std::string out = "# The zoo\n\nMade by `" + command + "`.\n\n```\n" + comparison_text(contenders, faces) + "```\n\n";
  out +=
      "*Clean*: a closed manifold without self-intersection. Per method and level: volume ratio to the input (where it "
      "is a solid) less 1. CPU seconds include reading.\n\n";
  out += "| file | faces | solid | clean |";
  std::string rule = "|---|---:|---|---|";
  for (const Contender& contender : contenders) {
    for (const std::int64_t target : faces) {
      out += " " + escaped(contender.name) + text(": %lld |", static_cast<long long>(target));
      rule += "---:|";
    }
    out += " CPU s | certified |";
    rule += "---:|---|";
  }
  out += "\n" + rule + "\n";
  for (std::size_t file = 0; file < contenders.front().models.size(); ++file) {
    if (witness(contenders, file).outcome == Model::Outcome::baked) out += row(contenders, file, faces);
  }
  const std::string without = failures(contenders);
  if (!without.empty()) out += "\n## Without cages\n\n| file | method | reason |\n|---|---|---|\n" + without;
  return out;
}

}  // namespace encage::zoo
