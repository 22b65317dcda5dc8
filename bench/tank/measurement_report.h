// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/measure.h"

#include <nlohmann/json.hpp>

#include <string>

namespace encage::tank {

/// The JSON keys that come from the measurement, and more about it.
nlohmann::ordered_json to_json(const Measurement& measurement);

/// A table of the strategies, and the ratios between them.
std::string to_text(const Measurement& measurement);

}  // namespace encage::tank
