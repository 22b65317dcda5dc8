// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>

namespace encage::zoo {

// Counts by exact predicates. A degenerate triangle of the cage counts in both.

/// Triangles of `cage` that have a point in common with one of `inner`.
std::int64_t touching_triangles(const TriangleMesh& cage, const TriangleMesh& inner);

/// Triangles of `cage` that have more in common with another one than the vertices or the edge that they share.
std::int64_t self_intersecting_triangles(const TriangleMesh& cage);

}  // namespace encage::zoo
