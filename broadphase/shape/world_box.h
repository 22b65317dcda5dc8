// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

namespace encage {

/// Upper bound of the largest n.x over the vertices. The computed value is at most 4 eps |n| radius below the exact
/// one, and no more than `tolerance` above it.
double support(const Surface& surface, const Eigen::Vector3d& n, double tolerance = 0) noexcept;

/// World box of a body at one pose, rounding included. If the shape has an outline, it is the outline's box. Otherwise
/// it is wider than the body by at most 2^-8 of its radius.
Eigen::AlignedBox3d pose_box(const SimpleShape& shape, const Placement& at) noexcept;

/// world_box() of a usable motion.
Eigen::AlignedBox3d usable_box(const Shape& shape, const Motion& motion) noexcept;

/// The box of the ball about the local origin: cheaper and looser than pose_box(), which it contains. For a compound it
/// is the world box of the compound's turned box.
Eigen::AlignedBox3d ball_box(const Shape& shape, const Placement& at) noexcept;

}  // namespace encage
