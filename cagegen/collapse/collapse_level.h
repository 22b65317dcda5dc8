// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"

#include <optional>

namespace encage::makers {

/// Makes a level by conservative collapse: cages from several starts, the smallest volume first, among them convex ones
/// that always come through. The first candidate that `accept` takes is finished and returned; the same for any number
/// of threads. Throws Error if none keeps the topology, and Cancelled.
LevelResult collapse_level(const Obstacle& obstacle, const LevelRequest& request, Control& control,
                           const Accept& accept);

/// The tightest of the convex cages, if it encloses less than `volume` and `accept` takes it: what other methods should
/// not be looser than.
std::optional<LevelResult> convex_level(const Obstacle& obstacle, const LevelRequest& request, double volume,
                                        Control& control, const Accept& accept);

}  // namespace encage::makers
