// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/turned_box.h"

#include "src/limits.h"

#include <algorithm>
#include <cmath>

namespace encage {

Eigen::AlignedBox3d turned_box(const Eigen::AlignedBox3d& box, const Eigen::Isometry3d& pose, double scale) noexcept {
  const Eigen::Vector3d middle = (0.5 * scale) * (box.min() + box.max());
  const Eigen::Vector3d half = (0.5 * scale) * (box.max() - box.min());
  const Eigen::Matrix3d size = pose.linear().cwiseAbs();
  const Eigen::Vector3d centre = pose.linear() * middle + pose.translation();
  const Eigen::Vector3d reach = size * half;
  // There are at most 14 roundings, each of a sum of the terms below.
  const Eigen::Vector3d slack = 16 * eps * (reach + size * middle.cwiseAbs() + pose.translation().cwiseAbs());
  return {centre - reach - slack, centre + reach + slack};
}

Eigen::AlignedBox3d swept_box(const Eigen::AlignedBox3d& box, const Motion& motion) noexcept {
  const Eigen::AlignedBox3d start = turned_box(box, motion.start, motion.scale);
  return motion.at_rest() ? start : start.merged(turned_box(box, motion.end, motion.scale));
}

bool boxes_apart(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b, double margin) noexcept {
  if (a.isEmpty() || b.isEmpty()) return false;
  const Eigen::Array3d gap = (b.min() - a.max()).array().max((a.min() - b.max()).array()).max(0.0);
  // Each gap and the norm have relative errors of a few eps.
  const double largest = gap.maxCoeff();
  return largest > 0 && std::isfinite(largest) && (gap / largest).matrix().norm() * largest * (1 - 16 * eps) > margin;
}

bool box_beyond(const Eigen::AlignedBox3d& box, const HalfSpace& plane, double margin) noexcept {
  double nearest = -plane.offset, size = std::abs(plane.offset);
  for (int k = 0; k < 3; ++k) {
    const double low = plane.normal[k] * box.min()[k], high = plane.normal[k] * box.max()[k];
    nearest += std::min(low, high);
    size += std::max(std::abs(low), std::abs(high));
  }
  // Four products and sums are each off by half an eps of `size`; the normal may be longer than 1 by 1e-9.
  return nearest > margin * (1 + 2e-9) + 8 * eps * size;
}

}  // namespace encage
