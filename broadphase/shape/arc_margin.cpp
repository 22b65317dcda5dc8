// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pose.h"
#include "broadphase/shape/compound.h"
#include "src/limits.h"

#include <algorithm>
#include <cmath>

namespace encage {
namespace {

/// Bounds the distance of the body, or of its primitives' cores, from a point of the body frame, but for roundings
/// below 1e-9 of it.
double largest_distance(const Shape& shape, const Eigen::Vector3d& from, bool cores) noexcept {
  double largest = 0;
  for_each_part(shape, Motion{.scale = 1}, [&](const MovingPart& part) {
    const SimpleShape& of = *part.shape;
    const double error = cores ? of.core_error_in_world(part.motion.scale) : of.error_in_world(part.motion.scale);
    const Eigen::Vector3d origin = Placement(part.motion.start, part.motion.scale).origin(of.frame);
    largest = std::max(largest, part.motion.scale * of.outer().radius + error + (origin - from).norm() + part.slack);
    return true;
  });
  return largest;
}

}  // namespace

double arc_margin(const Shape& shape, const Motion& motion, const Eigen::Vector3d& pivot) noexcept {
  if (motion.start.linear() == motion.end.linear()) return 0;
  // The Frobenius norm of R1 - R0 is sqrt(8) sin(angle/2).
  const double departure = departure_from_rigid(motion.start.linear()) + departure_from_rigid(motion.end.linear());
  const double norm = (motion.end.linear() - motion.start.linear()).norm() + 2 * departure;
  const double sine = std::min(1.0, norm / std::sqrt(8.0) * (1 + 1e-12));
  const double cosine = std::sqrt((1 - sine) * (1 + sine));
  // No rotation leads from one to the other.
  if (!(departure <= 0.1) || is_mirrored(motion.start) || is_mirrored(motion.end)) return infinity;
  // A ball about a point of a core turns with it and stays the same ball.
  // 1 - cos = sin^2 / (1 + cos) avoids cancellation.
  return largest_distance(shape, pivot, true) * motion.scale * (sine * sine / (1 + cosine)) * (1 + 1e-8);
}

double radius(const Shape& shape, const Eigen::Vector3d& pivot) noexcept {
  return largest_distance(shape, pivot, false) * (1 + 1e-8);
}

double correction_margin(const Shape& shape, double deviation, double scale) noexcept {
  return deviation == 0 ? 0 : radius(shape) * deviation * scale * (1 + 8 * eps);
}

}  // namespace encage
