// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include <array>

namespace encage {

using TriangleD = std::array<Eigen::Vector3d, 3>;

/// 0 for a degenerate triangle.
inline Eigen::Vector3d unit_normal(const TriangleD& t) { return (t[1] - t[0]).cross(t[2] - t[0]).stableNormalized(); }

/// A triangle whose corners move linearly between two positions.
struct MovingTriangle {
  TriangleD start, end;

  Eigen::Vector3d corner(int k, double t) const { return (1 - t) * start[k] + t * end[k]; }
};

/// True only if some axis separates the projections of the triangles by more than `distance` > 0. Any axis gives a
/// sound proof, even if it was rounded; `distance` has to cover the rounding of projections (4 eps times the largest
/// norm of a corner, for each triangle). The axes tried suffice in exact arithmetic: whichever features are closest,
/// face and vertex, two edges, or edge ends, their direction is among them. Degenerate triangles are allowed.
bool triangles_apart(const TriangleD& a, const TriangleD& b, double distance) noexcept;

/// True only if the triangles stay farther apart than `distance` > 0 while they move. Bisects time into pieces no
/// shorter than 2^-8 and searches, for each piece, for one axis that separates both its ends, hence all times between.
/// `distance` covers rounding as above.
bool moving_triangles_apart(const MovingTriangle& a, const MovingTriangle& b, double distance) noexcept;
/// The same. Adds the number of pieces of time that were tested.
bool moving_triangles_apart(const MovingTriangle& a, const MovingTriangle& b, double distance, int& pieces) noexcept;

}  // namespace encage
