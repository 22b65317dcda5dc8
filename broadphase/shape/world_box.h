// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

namespace encage {

/// Upper bound of the largest n.x over the vertices. As computed it is at most 4 eps |n| radius below the exact one,
/// and no more than `tolerance` above it.
double support(const Surface& surface, const Eigen::Vector3d& n, double tolerance = 0) noexcept;

/// World box of a body at one pose, rounding included. Where the shape has an outline it is the box of that; elsewhere
/// it is wider than the body by 2^-8 of its radius at most.
Eigen::AlignedBox3d pose_box(const SimpleShape& shape, const Placement& at) noexcept;

/// world_box() of a motion that is usable.
Eigen::AlignedBox3d usable_box(const Shape& shape, const Motion& motion) noexcept;

/// Cheaper and looser than pose_box(), which it contains: the box of the ball about the local origin. For a compound it
/// is the box of the compound's turned box.
Eigen::AlignedBox3d ball_box(const Shape& shape, const Placement& at) noexcept;

}  // namespace encage
