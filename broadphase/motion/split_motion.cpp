// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pose.h"
#include "src/files/number_text.h"
#include "src/limits.h"
#include "src/mesh/portable_trig.h"

#include <encage/error.h>
#include <encage/split_motion.h>

#include <cmath>
#include <string>

namespace encage {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double most_parts = 1e6;

/// The norm of the angular velocity, off by some eps of it, also where squares would underflow or overflow.
double speed_of(const VelocityMotion& motion) {
  const double largest = motion.angular_velocity.cwiseAbs().maxCoeff();
  return largest > 0 ? largest * (motion.angular_velocity / largest).norm() : 0;
}

[[noreturn]] void refuse(const std::string& reason) { throw Error("split motion: " + reason); }

/// Returns the number of parts.
int check(const VelocityMotion& motion, double largest_angle) {
  if (const std::string defect = motion_defect(Motion::resting(motion.start, motion.scale)); !defect.empty()) {
    refuse(defect);
  }
  if (!motion.velocity.allFinite()) refuse("the velocity is not finite");
  if (!motion.angular_velocity.allFinite()) refuse("the angular velocity is not finite");
  if (!(motion.duration >= 0 && motion.duration <= largest_length)) {
    refuse("the duration " + number_text(motion.duration) + " is negative or not finite");
  }
  if (!(motion.pivot.array().abs() <= largest_length).all()) refuse("the pivot is not finite or beyond 1e150");
  if (!(largest_angle > 0 && largest_angle <= 3.1)) {
    refuse("the largest angle " + number_text(largest_angle) + " is not between 0 and 3.1 radians");
  }
  // The excess keeps the parts' angles, rounded, at or below the largest.
  const double angle = speed_of(motion) * motion.duration * (1 + 1e-13);
  const double parts = std::ceil(angle / largest_angle);
  if (!(parts <= most_parts)) {
    refuse("the body turns by " + number_text(angle) + " radians, in more than a million parts of " +
           number_text(largest_angle));
  }
  return parts > 1 ? static_cast<int>(parts) : 1;
}

/// Returns the pose after a fraction of the duration.
Eigen::Isometry3d pose_at(const VelocityMotion& motion, double fraction) {
  const double time = fraction * motion.duration;
  Eigen::Isometry3d pose = motion.start;
  const Eigen::Vector3d arm = motion.scale * motion.pivot;
  const double speed = speed_of(motion);
  if (const double angle = speed * time; angle > 0) {
    const SinCos half = sincos_turns(angle / (4 * pi));
    const Eigen::Vector3d axis = motion.angular_velocity / speed;
    Eigen::Quaterniond turn;
    turn.w() = half.cos;
    turn.vec() = half.sin * axis;
    pose.linear() = turn.normalized().toRotationMatrix() * motion.start.linear();
    // The pivot stays on its straight path.
    pose.translation() += motion.start.linear() * arm - pose.linear() * arm;
  }
  pose.translation() += time * motion.velocity;
  return pose;
}

}  // namespace

std::vector<Motion> split_motion(const VelocityMotion& motion, double largest_angle) {
  const int count = check(motion, largest_angle);
  std::vector<Motion> parts;
  parts.reserve(static_cast<std::size_t>(count));
  Eigen::Isometry3d start = motion.start;
  for (int i = 1; i <= count; ++i) {
    const Motion part = {start, pose_at(motion, static_cast<double>(i) / count), motion.scale};
    if (const std::string defect = motion_defect(part); !defect.empty()) {
      refuse("part " + std::to_string(i) + " of " + std::to_string(count) + ": " + defect);
    }
    parts.push_back(part);
    start = part.end;
  }
  return parts;
}

}  // namespace encage
