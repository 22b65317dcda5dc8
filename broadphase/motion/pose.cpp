// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pose.h"

#include "src/files/number_text.h"
#include "src/limits.h"

namespace encage {

double departure_from_rigid(const Eigen::Matrix3d& linear) noexcept {
  // Entries of the product are off by at most 3 eps for lengths near 1; the Frobenius norm of nine such errors stays
  // below 16 eps.
  return (linear.transpose() * linear - Eigen::Matrix3d::Identity()).norm() * (1 + 16 * eps) + 16 * eps;
}

bool is_usable(const Eigen::Isometry3d& pose) noexcept {
  return pose.translation().cwiseAbs().maxCoeff() <= largest_length && pose.translation().allFinite() &&
         departure_from_rigid(pose.linear()) <= rigid_tolerance && !is_mirrored(pose);
}

std::string pose_defect(const Eigen::Isometry3d& pose) {
  if (is_usable(pose)) return "";
  if (!pose.matrix().topRows<3>().allFinite()) return "is not finite";
  if (pose.translation().cwiseAbs().maxCoeff() > largest_length) return "is farther than 1e150 away";
  if (is_mirrored(pose)) return "mirrors the body";
  return "is " + number_text(departure_from_rigid(pose.linear()), 3) +
         " from rigid, farther than 1e-9: correct it by nearest_rigid() or pose_from()";
}

bool is_mirrored(const Eigen::Isometry3d& pose) noexcept { return pose.linear().determinant() < 0; }

bool is_usable(const Motion& motion) noexcept {
  if (!is_usable(motion.start) || !is_usable(motion.end)) return false;
  if (!(motion.scale >= smallest_scale && motion.scale <= largest_scale)) return false;
  // The trace is 1 + 2 cos of the angle between the poses; it is off by no more than their departure from rigid and
  // rounding.
  return (motion.start.linear().transpose() * motion.end.linear()).trace() > -1 + 1e-6;
}

std::string motion_defect(const Motion& motion) {
  if (is_usable(motion)) return "";
  if (const std::string defect = pose_defect(motion.start); !defect.empty()) return "the start pose " + defect;
  if (const std::string defect = pose_defect(motion.end); !defect.empty()) return "the end pose " + defect;
  if (!(motion.scale >= smallest_scale && motion.scale <= largest_scale)) {
    return "the scale " + number_text(motion.scale) + " is not between 1e-50 and 1e50";
  }
  return "the rotation within the step reaches 180 degrees: split it, e.g. by split_motion()";
}

}  // namespace encage
