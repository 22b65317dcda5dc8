// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/separation/triangle_pair.h"

namespace encage {

/// Bounds of the distance of two triangles, and the points between which the upper one holds.
struct TriangleDistance {
  double lower = 0;
  double upper = 0;  ///< no less than the distance of the points
  Eigen::Vector3d point_a, point_b;
};

/// Returns lower <= distance <= upper for triangles whose corners are no farther than `error` from the given ones, both
/// together; at least 32 units of roundoff (2^-53) of the largest norm of a corner in `error` are for rounding here.
/// `upper` exceeds the computed distance by `error`, and `lower` falls short of it by little more, unless a triangle is
/// nearly degenerate. Degenerate triangles are allowed.
TriangleDistance triangle_distance(const TriangleD& a, const TriangleD& b, double error) noexcept;

/// True only if an edge of one triangle passes through the other triangle, and still does after every corner has moved
/// by `error` or less.
bool triangles_cross(const TriangleD& a, const TriangleD& b, double error) noexcept;

}  // namespace encage
