// SPDX-License-Identifier: Apache-2.0
#pragma once

// Steps of any rotation, as motions that queries accept.

#include <encage/export.h>
#include <encage/motion.h>

#include <Eigen/Geometry>

#include <vector>

namespace ENCAGE_EXPORT encage {

/// A body that moves at constant velocities for some time, as in a step of an engine: its pivot moves straight, and the
/// body turns uniformly about it, any number of times. Unlike two poses, this tells 190 degrees from -170.
struct VelocityMotion {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< of the pivot, world units per unit of time
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< world frame, radians per unit of time
  double duration = 1;                                         ///< >= 0
  double scale = 1;                                            ///< as in Motion
  Eigen::Vector3d pivot = Eigen::Vector3d::Zero();  ///< body frame, before scaling; usually the centre of mass
};

/// Splits the motion into parts of equal duration that each turn by at most `largest_angle`, in radians, in (0, 3.1],
/// usually pi/2. Each part is a Motion that queries accept: it starts where the one before ends, bit for bit. During a
/// part, points of the body leave their straight paths by at most arc_margin(shape, part, pivot). So queries about the
/// parts, one after the other, with that bound in the margin or as ContactOptions::arc, miss nothing of what the body
/// sweeps. Smaller angles give more parts and smaller bounds: r (1 - cos(angle / 2)) at a distance r from the axis.
/// Poses are rounded: points are off by less than 1e-13, and 1e-15 more for each radian, of their distance from the
/// pivot, and by 1e-15 of the coordinates.
///
/// Throws Error, which names value and reason, if the start pose is not usable, the scale is not between 1e-50 and
/// 1e50, a number is not finite or out of its range, the body goes farther than 1e150, or the parts are more than a
/// million. Re-entrant; the same bits on every machine.
std::vector<Motion> split_motion(const VelocityMotion& motion, double largest_angle = 1.5707963267948966);

}  // namespace encage
