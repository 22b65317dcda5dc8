// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/separation/triangle_pair.h"

#include <limits>
#include <span>

namespace encage {

/// True only if some axis separates the convex hull of some points from a triangle by more than `distance` >= 0. Any
/// axis gives a sound proof, however it was found; `distance` has to cover the rounding of projections (4 eps times the
/// largest norm of a point and of a corner). The axes are those of a search for the nearest points (Gilbert, Johnson
/// and Keerthi 1988), begun with `axis`; the last one is left there for a triangle nearby. Points and triangle may be
/// degenerate.
bool hull_apart(std::span<const Eigen::Vector3d> points, const TriangleD& triangle, double distance,
                Eigen::Vector3d& axis) noexcept;

/// How far a hull that moves and a triangle are apart at one time, as a search for the nearest points sees it.
struct HullGap {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< leads from the triangle to the hull; 0 if none was found
  double length = 0;                               ///< of the axis
  double low = 0;                                  ///< the least projection of the hull where it rests, on the axis
  double high = 0;                                 ///< the largest one of the triangle
  double lower = -std::numeric_limits<double>::infinity();  ///< along the axis, but for the rounding of projections
  double upper = std::numeric_limits<double>::infinity();   ///< two points are no farther apart, but for rounding
  bool passes = false;  ///< the axis proves a larger distance than that asked for, on the whole way
};

/// Finds how far the hull of `points`, moved by `moved`, and a triangle are apart. The search also ends when two points
/// are no farther apart than `distance`, or an axis proves that hull and triangle are while the hull moves on by `way`.
HullGap hull_gap(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& moved, const Eigen::Vector3d& way,
                 const TriangleD& triangle, double distance) noexcept;

struct NearestToHull {
  Eigen::Vector3d point;  ///< of the triangle; any if it crosses the hull
  Eigen::Vector3d axis;   ///< from there to the hull; 0 if they cross
};

/// Finds the point of a triangle that is nearest to the hull of some points, moved by `moved`.
NearestToHull nearest_to_hull(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& moved,
                              const TriangleD& triangle) noexcept;

}  // namespace encage
