// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/zoo/zoo.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace encage::zoo {

/// The same files in the same order, by one of several ways to make cages.
struct Contender {
  std::string name;  ///< of a method, or of a baseline
  bool baseline = false;
  std::vector<Model> models;
};

// Contenders side by side: certified or not, excess volume (ratio - 1) per level, CPU seconds.

/// Lines of the table for a terminal: one for each file and contender, none for a baseline that was skipped.
std::string comparison_head(const std::vector<std::int64_t>& faces);
std::string comparison_line(const std::string& contender, const Model& model, const std::vector<std::int64_t>& faces);

/// The summary (report.h) of each contender.
std::string comparison_text(const std::vector<Contender>& contenders, const std::vector<std::int64_t>& faces);

/// `models[]` as in report.h, of all contenders, each with `method`; `summaries.<name>`.
nlohmann::ordered_json comparison_json(const std::vector<Contender>& contenders,
                                       const std::vector<std::int64_t>& faces);

/// What is known of the file, whoever found out: of the first contender that baked it, or else of the first.
const Model& witness(const std::vector<Contender>& contenders, std::size_t file);

/// A document: a summary, a row for each mesh with the methods, one with the baselines beside the first method, and the
/// reasons of those that failed.
std::string comparison_markdown(const std::vector<Contender>& contenders, const std::vector<std::int64_t>& faces,
                                const std::string& command);

}  // namespace encage::zoo
