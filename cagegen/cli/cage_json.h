// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/cage.h>

#include <nlohmann/json.hpp>

#include <string>

namespace encage::tool {

/// `source`, `options`, `levels` (cages only, fine to coarse) and `truncated`: the keys that `bake`, `info` and
/// encage-zoo have in common.
nlohmann::ordered_json to_json(const CageHierarchy& hierarchy);

/// Indented text with a newline at the end. Paths may hold bytes that are no UTF-8: they are replaced.
std::string dump(const nlohmann::ordered_json& json);

}  // namespace encage::tool
