// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/simulate.h"

#include <nlohmann/json.hpp>

#include <string>

namespace encage::tank {

/// Steps, held bodies, detections, energy and CPU time of a simulation.
nlohmann::ordered_json to_json(const Simulation& simulation);

/// The same in a few lines.
std::string to_text(const Simulation& simulation);

}  // namespace encage::tank
