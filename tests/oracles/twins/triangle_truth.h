// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/exact_sweep.h"

#include <cstdint>

namespace encage::twins {

test::MovingMesh one_triangle(const test::MovingMesh& mesh, std::int64_t triangle);

/// True only if surfaces that never touch come as close as `distance` > 0. Closer approaches are found for certain if
/// they are closer by 2^-13 of the length of the paths; for small bodies also those that a search for the least
/// distance of triangles finds.
bool reach(const test::MovingMesh& a, const test::MovingMesh& b, double distance);

}  // namespace encage::twins
