// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/render/render.h"

#include <encage/cage.h>

#include <array>
#include <vector>

namespace encage::zoo {

// Pictures like figure 11 of Nested Cages (Sacht et al. 2015).

/// The input, a section through all layers across the shortest side of the bounds, and the outermost cage, each `size`
/// pixels wide and high. The hierarchy must hold its source and at least one level. Throws Error.
std::array<render::Image, 3> triplet(const CageHierarchy& hierarchy, render::Axis up, int size);

/// Pictures of one size, row by row; white where the last row has none. `columns` > 0.
render::Image tiled(const std::vector<render::Image>& pictures, int columns);

}  // namespace encage::zoo
