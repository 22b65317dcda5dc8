// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/comparison.h"
#include "bench/zoo/format.h"
#include "bench/zoo/report.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace encage::zoo {

using Json = nlohmann::ordered_json;
using Faces = std::vector<std::int64_t>;
using Contenders = std::vector<Contender>;

namespace {

std::string number(const std::optional<double>& value, const char* pattern) {
  return value ? format(pattern, *value) : "–";
}

bool certified(const Json& level) { return !level.is_null() && level.at("certified").get<bool>(); }

/// Volume ratio - 1, and why it is not to be taken at its word.
std::string excess_cell(const Json& level) {
  if (level.is_null()) return "–";
  const std::optional<double> ratio = volume_ratio(level);
  if (certified(level)) return ratio ? format("%.4f", *ratio - 1) : "–";
  if (level.value("faces", std::int64_t{0}) == 0) return "none";
  return number(ratio ? std::optional(*ratio - 1) : std::nullopt, "%.4f") +
         format(" (%lld+%lld)", level.value("hits", 0LL), level.value("self_hits", 0LL));
}

/// All levels of a model in one cell.
std::string excess_cells(const Model& model, const Faces& faces) {
  if (model.outcome == Model::Outcome::failed) return "failed";
  std::string out;
  for (std::size_t target = 0; target < faces.size(); ++target) {
    out += (target > 0 ? " / " : "") + excess_cell(level_for(model, faces, target));
  }
  return out;
}

/// A table's head: its first columns, then those that follow, aligned to the right.
std::string head(std::string columns, std::string rule, const std::vector<std::string>& more) {
  for (const std::string& column : more) {
    columns += " " + escaped(column) + " |";
    rule += "---:|";
  }
  return columns + "\n" + rule + "\n";
}

std::string levels_text(const Faces& faces) {
  std::string out;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    out += (i > 0 ? " / " : "") + format("%lld", static_cast<long long>(faces[i]));
  }
  return out;
}

std::string method_summary(const Contenders& contenders, const Faces& faces) {
  std::vector<std::string> columns = {"certified", "CPU s, median"};
  for (const std::int64_t target : faces) {
    columns.push_back(format("excess at %lld, median (meshes)", static_cast<long long>(target)));
  }
  std::string out = head("| method |", "|---|", columns);
  for (const Contender& contender : contenders) {
    if (contender.baseline) continue;
    const Summary summary = summarize(contender.models, faces);
    out +=
        "| " + escaped(contender.name) +
        format(" | %lld of %lld |", static_cast<long long>(summary.certified), static_cast<long long>(summary.meshes)) +
        " " + number(summary.median_cpu_seconds, "%.2f") + " |";
    for (const LevelSummary& level : summary.levels) {
      out +=
          " " + number(level.median_excess_volume, "%.4f") + format(" (%lld) |", static_cast<long long>(level.models));
    }
    out += "\n";
  }
  return out;
}

std::string baseline_line(const Contender& first, const Contender& baseline, const Faces& faces, std::size_t target) {
  long long tried = 0, made = 0, held = 0, touching = 0, crossing = 0;
  std::vector<double> excess;
  std::vector<double> first_excess;
  for (std::size_t i = 0; i < baseline.models.size(); ++i) {
    const Model& model = baseline.models[i];
    if (model.outcome == Model::Outcome::skipped) continue;
    const Json level = level_for(model, faces, target);
    if (level.is_null() && model.outcome == Model::Outcome::baked) continue;
    ++tried;
    if (level.is_null() || level.at("faces") == 0) continue;
    ++made;
    touching += level.at("hits") > 0 ? 1 : 0;
    crossing += level.at("self_hits") > 0 ? 1 : 0;
    if (!certified(level)) continue;
    ++held;
    const std::optional<double> ours = volume_ratio(level_for(first.models[i], faces, target));
    const std::optional<double> ratio = volume_ratio(level);
    if (!ours || !ratio) continue;
    excess.push_back(*ratio - 1);
    first_excess.push_back(*ours - 1);
  }
  return "| " + escaped(baseline.name) +
         format(" | %lld | %lld | %lld | %lld | %lld | %lld | ", static_cast<long long>(faces[target]), tried, made,
                held, touching, crossing) +
         number(median(std::move(excess)), "%.4f") + " | " + number(median(std::move(first_excess)), "%.4f") + " |\n";
}

std::string baseline_summary(const Contenders& contenders, const Faces& faces) {
  const Contender& first = contenders.front();
  std::string out = head("| baseline |", "|---|",
                         {"faces", "meshes", "a cage", "certified", "touch the input", "intersect themselves",
                          "excess, median", first.name + "'s, same meshes"});
  for (const Contender& contender : contenders) {
    for (std::size_t target = 0; contender.baseline && target < faces.size(); ++target) {
      out += baseline_line(first, contender, faces, target);
    }
  }
  return out;
}

std::string who_certified(const Contenders& contenders, std::size_t file) {
  std::string names;
  bool all = true;
  for (const Contender& contender : contenders) {
    if (contender.baseline) continue;
    const bool held = contender.models[file].certified();
    all = all && held;
    if (held) names += (names.empty() ? "" : ", ") + contender.name;
  }
  return all ? "all" : names.empty() ? "none" : names;
}

std::string method_row(const Contenders& contenders, std::size_t file, const Faces& faces) {
  const Model& known = witness(contenders, file);
  const Json& source = known.figures.at("source");
  std::string out = "| " + escaped(known.file.filename().string()) +
                    format(" | %lld | %s | %s |", source.at("faces").get<long long>(),
                           source.at("solid").get_ref<const std::string&>().c_str(), yes(known.clean()));
  std::string seconds;
  for (const Contender& contender : contenders) {
    if (contender.baseline) continue;
    const Model& model = contender.models[file];
    out += " " + excess_cells(model, faces) + " |";
    if (!seconds.empty()) seconds += " / ";
    seconds += model.outcome == Model::Outcome::baked ? format("%.2f", model.cpu_seconds()) : "–";
  }
  return out + " " + seconds + " | " + escaped(who_certified(contenders, file)) + " |\n";
}

std::string method_table(const Contenders& contenders, const Faces& faces) {
  std::vector<std::string> columns;
  for (const Contender& contender : contenders) {
    if (!contender.baseline) columns.push_back(contender.name);
  }
  columns.insert(columns.end(), {"CPU s", "certified"});
  std::string out = head("| file | faces | solid | clean |", "|---|---:|---|---|", columns);
  for (std::size_t file = 0; file < contenders.front().models.size(); ++file) {
    if (witness(contenders, file).outcome == Model::Outcome::baked) out += method_row(contenders, file, faces);
  }
  return out;
}

std::string baseline_table(const Contenders& contenders, const Faces& faces) {
  std::vector<std::string> columns = {contenders.front().name};
  for (const Contender& contender : contenders) {
    if (contender.baseline) columns.push_back(contender.name);
  }
  std::string out = head("| file |", "|---|", columns);
  for (std::size_t file = 0; file < contenders.front().models.size(); ++file) {
    std::string row;
    bool any = false;
    for (const Contender& contender : contenders) {
      if (!contender.baseline) continue;
      const Model& model = contender.models[file];
      any = any || model.outcome != Model::Outcome::skipped;
      row += " " + excess_cells(model, faces) + " |";
    }
    const Model& ours = contenders.front().models[file];
    if (any)
      out += "| " + escaped(ours.file.filename().string()) + " | " + excess_cells(ours, faces) + " |" + row + "\n";
  }
  return out;
}

std::string failures(const Contenders& contenders) {
  std::string out;
  for (std::size_t file = 0; file < contenders.front().models.size(); ++file) {
    for (const Contender& contender : contenders) {
      const Model& model = contender.models[file];
      if (model.outcome == Model::Outcome::baked || model.outcome == Model::Outcome::skipped) continue;
      const bool refused = model.outcome == Model::Outcome::no_mesh;
      out += "| " + escaped(model.file.filename().string()) + " | " + (refused ? "all" : escaped(contender.name)) +
             " | " + escaped(reason(model)) + " |\n";
      if (refused) break;
    }
  }
  return out;
}

}  // namespace

const Model& witness(const Contenders& contenders, std::size_t file) {
  for (const Contender& contender : contenders) {
    if (!contender.baseline && contender.models[file].outcome == Model::Outcome::baked) return contender.models[file];
  }
  return contenders.front().models[file];
}

std::string comparison_markdown(const Contenders& contenders, const Faces& faces, const std::string& command) {
  const std::string levels = levels_text(faces);
  // Lines of text wrap at 120 columns, as in the other documents.
  std::string out =
      "# The methods side by side\n\nMade by\n\n```\n" + command + "\n```\n\n" + method_summary(contenders, faces);
  out +=
      "\nLevels of " + levels +
      " faces, each around the one before. *Excess*: volume ratio to the input, less 1, of clean\nmeshes that have the "
      "level. *Clean*: a closed manifold without self-intersection. CPU seconds of the whole bake,\nreading included.";
  const long long refused = static_cast<long long>(summarize(contenders.front().models, faces).no_meshes);
  if (refused > 0) out += format(" %lld files hold no usable mesh.", refused);
  out += "\n";
  const bool baselines =
      std::any_of(contenders.begin(), contenders.end(), [](const Contender& c) { return c.baseline; });
  if (baselines) {
    out += "\n## Beside plain methods\n\n" + baseline_summary(contenders, faces);
    out +=
        "\nOn clean meshes, at levels smaller than the mesh. Baselines enclose the input alone, ours the level before "
        "as "
        "well,\nso they have the easier task. *Meshes*: tried; *a cage*: the baseline made one; *certified*: it holds "
        "as "
        "ours do. The\nlast two columns: medians over the meshes on which the baseline's cage is certified.\n";
  }
  out += "\n## Mesh by mesh\n\nPer method: excess at " + levels +
         " faces (– without a level, or without a solid).\n\n" + method_table(contenders, faces);
  if (baselines) {
    out +=
        "\n## Plain methods, mesh by mesh\n\nExcess at " + levels +
        " faces. (a+b): not certified; a triangles of the cage touch the input, b intersect another one\nof the cage. "
        "*None*: no such cage was found.\n\n" +
        baseline_table(contenders, faces);
  }
  const std::string without = failures(contenders);
  if (!without.empty()) out += "\n## Without cages\n\n| file | method | reason |\n|---|---|---|\n" + without;
  return out;
}

}  // namespace encage::zoo
