// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/octopus/implicit.h"

namespace encage::octopus {

/// Half the side of a cube about 0 that holds the shape.
inline constexpr double octopus_half_width = 1.5;

/// Mantle, head, eyes and eight tapering, curling arms with suckers. What a mesh with edges of length `detail` cannot
/// show is left out or kept thicker.
ImplicitSurface octopus_shape(double detail);

}  // namespace encage::octopus
