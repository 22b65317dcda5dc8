// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/covers/compare.h"

#include <nlohmann/json.hpp>

#include <iosfwd>
#include <string>

namespace encage::covers {

/// A Markdown table.
void print(std::ostream& out, const std::string& title, const Comparison& comparison);

nlohmann::ordered_json to_json(const Comparison& comparison);

}  // namespace encage::covers
