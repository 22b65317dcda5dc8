// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/report.h"

#include "bench/zoo/format.h"

#include <utility>

namespace encage::zoo {

using Json = nlohmann::ordered_json;

namespace {

std::string ratio_text(const Json& level) {
  const std::optional<double> value = volume_ratio(level);
  return value ? format("%.4f", *value) : "–";
}

}  // namespace

Summary summarize(const std::vector<Model>& models, const std::vector<std::int64_t>& faces) {
  Summary summary;
  std::vector<double> cpu_seconds;
  for (const Model& model : models) {
    if (model.outcome == Model::Outcome::skipped) continue;
    if (model.outcome == Model::Outcome::no_mesh) {
      ++summary.no_meshes;
      continue;
    }
    ++summary.meshes;
    if (model.certified()) ++summary.certified;
    if (model.outcome == Model::Outcome::baked) cpu_seconds.push_back(model.cpu_seconds());
  }
  summary.median_cpu_seconds = median(std::move(cpu_seconds));
  for (std::size_t target = 0; target < faces.size(); ++target) {
    std::vector<double> excess;
    for (const Model& model : models) {
      if (!model.clean()) continue;
      const Json level = level_for(model, faces, target);
      const std::optional<double> value = volume_ratio(level);
      if (value && level.at("certified").get<bool>()) excess.push_back(*value - 1);
    }
    const auto count = static_cast<std::int64_t>(excess.size());
    summary.levels.push_back({faces[target], count, median(std::move(excess))});
  }
  return summary;
}

std::string table_head(const std::vector<std::int64_t>& faces) {
  std::string line = format("%-36s %8s %-12s %-5s %8s", "file", "faces", "solid", "clean", "CPU s");
  for (const std::int64_t target : faces) line += format("  %6lld: ratio", static_cast<long long>(target));
  return line + "  certified\n";
}

std::string table_line(const Model& model, const std::vector<std::int64_t>& faces) {
  std::string line = format("%-36s", model.file.filename().c_str());
  if (model.outcome != Model::Outcome::baked) return line + " " + reason(model) + "\n";
  const Json& source = model.figures.at("source");
  line += format(" %8lld %-12s %-5s %8.2f", source.at("faces").get<long long>(),
                 source.at("solid").get_ref<const std::string&>().c_str(), yes(model.clean()), model.cpu_seconds());
  for (std::size_t target = 0; target < faces.size(); ++target) {
    const Json level = level_for(model, faces, target);
    if (level.is_null()) {
      line += format("  %13s", "-");
    } else {
      const std::optional<double> value = volume_ratio(level);
      line += format("  %6lld %6s", level.at("faces").get<long long>(), value ? format("%.3f", *value).c_str() : "-");
    }
  }
  return line + "  " + yes(model.certified()) + "\n";
}

std::string to_text(const Summary& summary) {
  std::string out = format("certified: %lld of %lld meshes", static_cast<long long>(summary.certified),
                           static_cast<long long>(summary.meshes));
  out += format("; %lld files hold no usable mesh\n", static_cast<long long>(summary.no_meshes));
  if (summary.median_cpu_seconds) out += format("CPU seconds a mesh, median: %.2f\n", *summary.median_cpu_seconds);
  for (const LevelSummary& level : summary.levels) {
    if (!level.median_excess_volume) continue;
    out +=
        format("excess volume (ratio - 1) at %lld faces, median of %lld clean meshes: %.4f\n",
               static_cast<long long>(level.faces), static_cast<long long>(level.models), *level.median_excess_volume);
  }
  return out;
}

Json to_json(const Model& model) {
  Json entry = {{"file", model.file.string()},
                {"error", model.error.empty() ? Json(nullptr) : Json(model.error)},
                {"holds_mesh", model.outcome != Model::Outcome::no_mesh}};
  if (model.outcome == Model::Outcome::baked) entry.update(model.figures);
  return entry;
}

Json to_json(const Summary& summary) {
  const auto or_null = [](const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); };
  Json levels = Json::array();
  for (const LevelSummary& level : summary.levels) {
    levels.push_back({{"faces", level.faces},
                      {"clean_models", level.models},
                      {"median_excess_volume", or_null(level.median_excess_volume)}});
  }
  return {{"meshes", summary.meshes},
          {"certified", summary.certified},
          {"no_meshes", summary.no_meshes},
          {"median_cpu_seconds", or_null(summary.median_cpu_seconds)},
          {"levels", std::move(levels)}};
}

Json to_json(const std::vector<Model>& models, const Summary& summary) {
  Json list = Json::array();
  for (const Model& model : models) list.push_back(to_json(model));
  return {{"models", std::move(list)}, {"summary", to_json(summary)}};
}

std::string to_markdown(const std::vector<Model>& models, const Summary& summary,
                        const std::vector<std::int64_t>& faces, const std::string& command) {
  std::string out = "# The zoo\n\nMade by `" + command + "`.\n\n```\n" + to_text(summary) + "```\n\n";
  out +=
      "*Clean*: a closed manifold without self-intersection. Per level: faces, volume ratio to the input (where it\n"
      "is a solid), the start that won. CPU seconds include reading.\n\n";
  out += "| file | faces | solid | clean | CPU s |";
  std::string rule = "|---|---:|---|---|---:|";
  for (const std::int64_t target : faces) {
    out += format(" %lld: faces | ratio | start |", static_cast<long long>(target));
    rule += "---:|---:|---|";
  }
  out += " certified |\n" + rule + "---|\n";
  for (const Model& model : models) {
    if (model.outcome != Model::Outcome::baked) continue;
    const Json& source = model.figures.at("source");
    out += "| " + escaped(model.file.filename().string()) +
           format(" | %lld | %s | %s | %.2f |", source.at("faces").get<long long>(),
                  source.at("solid").get_ref<const std::string&>().c_str(), yes(model.clean()), model.cpu_seconds());
    for (std::size_t target = 0; target < faces.size(); ++target) {
      const Json level = level_for(model, faces, target);
      if (level.is_null()) {
        out += " – | – | – |";
      } else {
        out += format(" %lld | ", level.at("faces").get<long long>()) + ratio_text(level) + " | " +
               escaped(level.at("start").get<std::string>()) + " |";
      }
    }
    out += std::string(" ") + yes(model.certified()) + " |\n";
  }
  if (summary.certified < summary.meshes || summary.no_meshes > 0) {
    out += "\n## Without cages\n\n| file | reason |\n|---|---|\n";
    for (const Model& model : models) {
      if (model.outcome == Model::Outcome::baked) continue;
      out += "| " + escaped(model.file.filename().string()) + " | " + escaped(reason(model)) + " |\n";
    }
  }
  return out;
}

}  // namespace encage::zoo
