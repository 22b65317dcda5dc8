// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pair_frame.h"

#include "broadphase/motion/pose.h"
#include "src/limits.h"

namespace encage {

// Large coordinates that both bodies share cancel first.
Eigen::Vector3d origin_offset(const LocalFrame& a, const Placement& at_a, const LocalFrame& b,
                              const Placement& at_b) noexcept {
  return (at_b.pose.translation() - at_a.pose.translation()) +
         (at_b.pose.linear() * (at_b.scale * b.origin) - at_a.pose.linear() * (at_a.scale * a.origin));
}

AffineMap relative_frame(const LocalFrame& a, const Placement& at_a, const LocalFrame& b,
                         const Placement& at_b) noexcept {
  const Eigen::Matrix3d to_a = at_a.pose.linear().transpose();
  return {to_a * at_b.pose.linear(), to_a * origin_offset(a, at_a, b, at_b)};
}

double required_distance(const LocalFrame& a, const Placement& at_a, const LocalFrame& b, const Placement& at_b,
                         double margin) noexcept {
  const double size =
      at_a.scale * a.reach() + at_b.scale * b.reach() + at_a.pose.translation().norm() + at_b.pose.translation().norm();
  const double departure = departure_from_rigid(at_a.pose.linear()) + departure_from_rigid(at_b.pose.linear());
  return margin * (1 + 64 * eps + 4 * departure) + (256 * eps + 32 * departure) * size;
}

}  // namespace encage
