// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/shape.h>

namespace encage {

/// Box of a box that turns: contains R (scale x) + t for all x in `box`, rounding included. Much cheaper than
/// pose_box(), and looser by a factor sqrt(3) at most. The pose has to be usable.
Eigen::AlignedBox3d turned_box(const Eigen::AlignedBox3d& box, const Eigen::Isometry3d& pose,
                               double scale = 1) noexcept;

/// True if all points of the box are proven farther than `margin` from the half-space. What is true
/// of a box is true of every box in it. Answers false for infinite boxes.
bool box_beyond(const Eigen::AlignedBox3d& box, const HalfSpace& plane, double margin) noexcept;

}  // namespace encage
