// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/report.h"

#include <algorithm>
#include <cstdio>

namespace encage::zoo {

using Json = nlohmann::ordered_json;

namespace {

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

template <class... Values>
std::string text(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

std::optional<double> ratio(const Json& level) {
  if (level.is_null() || level.at("volume_ratio").is_null()) return std::nullopt;
  return level.at("volume_ratio").get<double>();
}

std::string ratio_text(const Json& level) {
  const std::optional<double> value = ratio(level);
  return value ? text("%.4f", *value) : "–";
}

const char* yes(bool value) { return value ? "yes" : "no"; }

/// Messages begin with the file's path, which the table has already.
std::string reason(const Model& model) {
  const std::string prefix = model.file.string() + ": ";
  return model.error.starts_with(prefix) ? model.error.substr(prefix.size()) : model.error;
}

std::string escaped(std::string cell) {
  for (std::size_t i = 0; (i = cell.find('|', i)) != std::string::npos; i += 2) cell.insert(i, "\\");
  std::replace(cell.begin(), cell.end(), '\n', ' ');
  return cell;
}

}  // namespace

Summary summarize(const std::vector<Model>& models, const std::vector<std::int64_t>& faces) {
  Summary summary;
  std::vector<double> cpu_seconds;
  for (const Model& model : models) {
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
      if (const auto value = ratio(level_for(model, faces, target))) excess.push_back(*value - 1);
    }
    const auto count = static_cast<std::int64_t>(excess.size());
    summary.levels.push_back({faces[target], count, median(std::move(excess))});
  }
  return summary;
}

std::string table_head(const std::vector<std::int64_t>& faces) {
  std::string line = text("%-36s %8s %-12s %-5s %8s", "file", "faces", "solid", "clean", "CPU s");
  for (const std::int64_t target : faces) line += text("  %6lld: ratio", static_cast<long long>(target));
  return line + "  certified\n";
}

std::string table_line(const Model& model, const std::vector<std::int64_t>& faces) {
  std::string line = text("%-36s", model.file.filename().c_str());
  if (model.outcome != Model::Outcome::baked) return line + " " + reason(model) + "\n";
  const Json& source = model.figures.at("source");
  line += text(" %8lld %-12s %-5s %8.2f", source.at("faces").get<long long>(),
               source.at("solid").get_ref<const std::string&>().c_str(), yes(model.clean()), model.cpu_seconds());
  for (std::size_t target = 0; target < faces.size(); ++target) {
    const Json level = level_for(model, faces, target);
    if (level.is_null()) {
      line += text("  %13s", "-");
    } else {
      const std::optional<double> value = ratio(level);
      line += text("  %6lld %6s", level.at("faces").get<long long>(), value ? text("%.3f", *value).c_str() : "-");
    }
  }
  return line + "  " + yes(model.certified()) + "\n";
}

std::string to_text(const Summary& summary) {
  std::string out = text("certified: %lld of %lld meshes", static_cast<long long>(summary.certified),
                         static_cast<long long>(summary.meshes));
  out += text("; %lld files hold no usable mesh\n", static_cast<long long>(summary.no_meshes));
  if (summary.median_cpu_seconds) out += text("CPU seconds a mesh, median: %.2f\n", *summary.median_cpu_seconds);
  for (const LevelSummary& level : summary.levels) {
    if (!level.median_excess_volume) continue;
    out += text("excess volume (ratio - 1) at %lld faces, median of %lld clean meshes: %.4f\n",
                static_cast<long long>(level.faces), static_cast<long long>(level.models), *level.median_excess_volume);
  }
  return out;
}

Json to_json(const std::vector<Model>& models, const Summary& summary) {
  Json list = Json::array();
  for (const Model& model : models) {
    Json entry = {{"file", model.file.string()},
                  {"error", model.error.empty() ? Json(nullptr) : Json(model.error)},
                  {"holds_mesh", model.outcome != Model::Outcome::no_mesh}};
    if (model.outcome == Model::Outcome::baked) entry.update(model.figures);
    list.push_back(std::move(entry));
  }
  Json levels = Json::array();
  for (const LevelSummary& level : summary.levels) {
    levels.push_back(
        {{"faces", level.faces},
         {"clean_models", level.models},
         {"median_excess_volume", level.median_excess_volume ? Json(*level.median_excess_volume) : Json(nullptr)}});
  }
  return {{"models", std::move(list)},
          {"summary",
           {{"meshes", summary.meshes},
            {"certified", summary.certified},
            {"no_meshes", summary.no_meshes},
            {"median_cpu_seconds", summary.median_cpu_seconds ? Json(*summary.median_cpu_seconds) : Json(nullptr)},
            {"levels", std::move(levels)}}}};
}

std::string to_markdown(const std::vector<Model>& models, const Summary& summary,
                        const std::vector<std::int64_t>& faces, const std::string& command) {
  std::string out = "# The zoo\n\nMade by `" + command + "`.\n\n```\n" + to_text(summary) + "```\n\n";
  out +=
      "*Clean*: a closed manifold without self-intersection. Per level: faces, volume ratio to the input (where it "
      "is a solid), the start that won. CPU seconds include reading.\n\n";
  out += "| file | faces | solid | clean | CPU s |";
  std::string rule = "|---|---:|---|---|---:|";
  for (const std::int64_t target : faces) {
    out += text(" %lld: faces | ratio | start |", static_cast<long long>(target));
    rule += "---:|---:|---|";
  }
  out += " certified |\n" + rule + "---|\n";
  for (const Model& model : models) {
    if (model.outcome != Model::Outcome::baked) continue;
    const Json& source = model.figures.at("source");
    out += "| " + escaped(model.file.filename().string()) +
           text(" | %lld | %s | %s | %.2f |", source.at("faces").get<long long>(),
                source.at("solid").get_ref<const std::string&>().c_str(), yes(model.clean()), model.cpu_seconds());
    for (std::size_t target = 0; target < faces.size(); ++target) {
      const Json level = level_for(model, faces, target);
      if (level.is_null()) {
        out += " – | – | – |";
      } else {
        out += text(" %lld | ", level.at("faces").get<long long>()) + ratio_text(level) + " | " +
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
