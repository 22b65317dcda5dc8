// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/separation/triangle_pair.h"

#include <span>

namespace encage {

/// True only if some axis separates the convex hull of some points from a triangle by more than `distance` >= 0. Any
/// axis gives a sound proof, however it was found; `distance` has to cover the rounding of projections (4 eps times the
/// largest norm of a point and of a corner). The axes are those of a search for the nearest points (Gilbert, Johnson
/// and Keerthi 1988), begun with `axis`; the last one is left there for a triangle nearby. Points and triangle may be
/// degenerate.
bool hull_apart(std::span<const Eigen::Vector3d> points, const TriangleD& triangle, double distance,
                Eigen::Vector3d& axis) noexcept;

}  // namespace encage
