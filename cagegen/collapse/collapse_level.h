// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"

namespace encage::makers {

/// Makes a level by conservative collapse: cages from several starts, the smallest volume first, at last the hull. The
/// first candidate that `accept` takes is finished and returned; the same for any number of threads. Throws Error if
/// none keeps the topology, and Cancelled.
LevelResult collapse_level(const Obstacle& obstacle, const LevelRequest& request, Control& control,
                           const Accept& accept);

/// The convex hull as the level, for sources too small to collapse. Throws the same.
LevelResult hull_level(const Obstacle& obstacle, const LevelRequest& request, Control& control, const Accept& accept);

}  // namespace encage::makers
