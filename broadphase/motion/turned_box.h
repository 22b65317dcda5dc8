// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/motion.h>

namespace encage {

/// Returns an axis-aligned box that contains R (scale x) + t for all x in `box`, rounding included. Its extents are at
/// most sqrt(3) times those of `box`, scaled. The pose has to be usable.
Eigen::AlignedBox3d turned_box(const Eigen::AlignedBox3d& box, const Eigen::Isometry3d& pose,
                               double scale = 1) noexcept;

/// The same during a motion.
Eigen::AlignedBox3d swept_box(const Eigen::AlignedBox3d& box, const Motion& motion) noexcept;

/// True if the boxes are proven farther apart than `margin`.
bool boxes_apart(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b, double margin) noexcept;

/// True if all points of the box are proven farther than `margin` from the half-space. If it is true for a box, it is
/// true for every box inside that box. False for infinite boxes.
bool box_beyond(const Eigen::AlignedBox3d& box, const HalfSpace& plane, double margin) noexcept;

}  // namespace encage
