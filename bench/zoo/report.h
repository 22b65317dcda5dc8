// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/zoo/zoo.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace encage::zoo {

struct LevelSummary {
  std::int64_t faces = 0;                      ///< the target
  std::int64_t models = 0;                     ///< clean models with such a level, certified
  std::optional<double> median_excess_volume;  ///< of those, volume ratio - 1
};

struct Summary {
  std::int64_t meshes = 0;     ///< files that hold faces; without those that were skipped
  std::int64_t certified = 0;  ///< of them, every level certified
  std::int64_t no_meshes = 0;  ///< files refused by the reader
  std::optional<double> median_cpu_seconds;
  std::vector<LevelSummary> levels;
};

Summary summarize(const std::vector<Model>& models, const std::vector<std::int64_t>& faces);

/// One line of the table for a terminal, and its headings.
std::string table_head(const std::vector<std::int64_t>& faces);
std::string table_line(const Model& model, const std::vector<std::int64_t>& faces);
std::string to_text(const Summary& summary);

/// `file`, `error` (null if none), `holds_mesh` and the keys of `encage bake --json`.
nlohmann::ordered_json to_json(const Model& model);
nlohmann::ordered_json to_json(const Summary& summary);

/// `models[]` with the keys above; `summary`.
nlohmann::ordered_json to_json(const std::vector<Model>& models, const Summary& summary);

/// A document: summary, table of the meshes, list of the files refused.
std::string to_markdown(const std::vector<Model>& models, const Summary& summary,
                        const std::vector<std::int64_t>& faces, const std::string& command);

}  // namespace encage::zoo
