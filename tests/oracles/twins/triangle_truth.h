// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/exact_sweep.h"

#include <cstdint>

namespace encage::twins {

test::MovingMesh one_triangle(const test::MovingMesh& mesh, std::int64_t triangle);

/// Whether surfaces that never touch come as close as `distance` > 0. True only if they do. Seen for certain if they
/// come closer by 2^-13 of the way they go; of small bodies also what a search for the least distance of triangles
/// finds.
bool reach(const test::MovingMesh& a, const test::MovingMesh& b, double distance);

}  // namespace encage::twins
