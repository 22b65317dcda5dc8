// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/report.h"
#include "bench/zoo/zoo.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace encage::zoo {

// What the reports have in common.

using bench::escaped;
using bench::format;

/// No value of no values.
std::optional<double> median(const std::vector<double>& values);

/// Of a level's figures, which may be null; no value if the source is no solid.
std::optional<double> volume_ratio(const nlohmann::ordered_json& level);

const char* yes(bool value);

/// Why there are no cages. Messages begin with the file's path, which the tables have already.
std::string reason(const Model& model);

}  // namespace encage::zoo
