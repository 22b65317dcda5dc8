// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/comparison.h"

#include "bench/zoo/format.h"
#include "bench/zoo/report.h"

#include <optional>
#include <utility>

namespace encage::zoo {

using Json = nlohmann::ordered_json;

std::string comparison_head(const std::vector<std::int64_t>& faces) {
  std::string line = format("%-36s %-16s %8s", "file", "method", "CPU s");
  for (const std::int64_t target : faces) line += format("  %8lld", static_cast<long long>(target));
  return line + "  certified   (per level: volume ratio - 1)\n";
}

std::string comparison_line(const std::string& contender, const Model& model, const std::vector<std::int64_t>& faces) {
  if (model.outcome == Model::Outcome::skipped) return {};
  std::string line = format("%-36s %-16s", model.file.filename().c_str(), contender.c_str());
  if (model.outcome != Model::Outcome::baked) return line + " " + reason(model) + "\n";
  line += format(" %8.2f", model.cpu_seconds());
  for (std::size_t target = 0; target < faces.size(); ++target) {
    const std::optional<double> ratio = volume_ratio(level_for(model, faces, target));
    line += format("  %8s", ratio ? format("%.4f", *ratio - 1).c_str() : "-");
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
      if (model.outcome == Model::Outcome::skipped) continue;
      Json entry = to_json(model);
      entry["method"] = contender.name;
      models.push_back(std::move(entry));
    }
    summaries[contender.name] = to_json(summarize(contender.models, faces));
  }
  return {{"models", std::move(models)}, {"summaries", std::move(summaries)}};
}

}  // namespace encage::zoo
