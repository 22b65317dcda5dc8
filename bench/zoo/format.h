// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/zoo/zoo.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

namespace encage::zoo {

// What the reports have in common.

template <class... Values>
std::string text(const char* format, Values... values) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, values...);
  return buffer;
}

std::optional<double> median(std::vector<double> values);

/// Of a level's figures, which may be null; no value if the source is no solid.
std::optional<double> volume_ratio(const nlohmann::ordered_json& level);

const char* yes(bool value);

/// Why there are no cages. Messages begin with the file's path, which the tables have already.
std::string reason(const Model& model);

/// As a cell of a Markdown table.
std::string escaped(std::string cell);

}  // namespace encage::zoo
