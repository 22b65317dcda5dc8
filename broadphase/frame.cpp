// SPDX-License-Identifier: Apache-2.0
#include "broadphase/frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace encage {
namespace {

// Twice the unit roundoff: the bounds below are counted in it, with room to spare.
constexpr double eps = std::numeric_limits<double>::epsilon();

double largest_radius(const Shape& shape) {
  double radius = shape.fine.radius;
  for (const Surface& cage : shape.cages) radius = std::max(radius, cage.radius);
  return radius;
}

/// Largest n.x over the vertices, as computed: at most 4 eps |n| radius below the exact one.
/// A box is skipped if its bound is no larger than a value at hand; both carry that error.
double support(const Surface& surface, const Eigen::Vector3d& n) {
  const auto bound = [&](const BvhNode& node) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
      sum += std::max(n[k] * static_cast<double>(node.lower[k]), n[k] * static_cast<double>(node.upper[k]));
    }
    return sum;
  };
  double best = -std::numeric_limits<double>::infinity();
  std::array<std::int32_t, Bvh::max_depth + 2> stack;
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const BvhNode& node = surface.nodes[stack[--size]];
    if (bound(node) <= best) continue;
    if (node.leaf()) {
      for (std::int32_t t = node.first; t < node.first + node.count; ++t) {
        for (const Eigen::Vector3f& v : surface.triangles[t]) best = std::max(best, n.dot(v.cast<double>()));
      }
      continue;
    }
    const bool first_is_higher = bound(surface.nodes[node.first]) >= bound(surface.nodes[node.first + 1]);
    stack[size++] = node.first + (first_is_higher ? 1 : 0);
    stack[size++] = node.first + (first_is_higher ? 0 : 1);
  }
  return best;
}

/// Covers the rounding of a world coordinate and the error of the fine vertices.
double world_slack(const Shape& shape, const Eigen::Isometry3d& pose, double radius) {
  const double size = radius + shape.origin.norm() + pose.translation().norm();
  return 32 * eps * size + (1 + 1e-8) * shape.outer_error();
}

}  // namespace

double departure_from_rigid(const Eigen::Matrix3d& linear) noexcept {
  // Entries of the product are off by at most 3 eps for lengths near 1; the
  // Frobenius norm of nine such errors stays below 16 eps.
  return (linear.transpose() * linear - Eigen::Matrix3d::Identity()).norm() * (1 + 16 * eps) + 16 * eps;
}

bool is_usable(const Eigen::Isometry3d& pose) noexcept {
  // Larger coordinates could overflow where bounds are added up.
  constexpr double largest = 1e150;
  return pose.translation().cwiseAbs().maxCoeff() <= largest && pose.translation().allFinite() &&
         departure_from_rigid(pose.linear()) <= 1e-9;
}

PairFrame relative_frame(const Shape& a, const Eigen::Isometry3d& pose_a, const Shape& b,
                         const Eigen::Isometry3d& pose_b) noexcept {
  const Eigen::Vector3d offset =
      (pose_b.translation() - pose_a.translation()) + (pose_b.linear() * b.origin - pose_a.linear() * a.origin);
  return {pose_a.linear().transpose() * pose_b.linear(), pose_a.linear().transpose() * offset};
}

double required_distance(const Shape& a, const Eigen::Isometry3d& pose_a, const Shape& b,
                         const Eigen::Isometry3d& pose_b, double margin) noexcept {
  const double size = largest_radius(a) + largest_radius(b) + a.origin.norm() + b.origin.norm() +
                      pose_a.translation().norm() + pose_b.translation().norm();
  const double departure = departure_from_rigid(pose_a.linear()) + departure_from_rigid(pose_b.linear());
  return margin * (1 + 64 * eps + 4 * departure) + (256 * eps + 32 * departure) * size;
}

bool boxes_apart(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b, double margin) noexcept {
  if (a.isEmpty() || b.isEmpty()) return false;
  const Eigen::Array3d gap = (b.min() - a.max()).array().max((a.min() - b.max()).array()).max(0.0);
  // Each gap and the norm are off by a few eps relatively.
  const double largest = gap.maxCoeff();
  return largest > 0 && std::isfinite(largest) && (gap / largest).matrix().norm() * largest * (1 - 16 * eps) > margin;
}

Eigen::AlignedBox3d pose_box(const Shape& shape, const Eigen::Isometry3d& pose) noexcept {
  const Surface& surface = shape.outer();
  const double slack = world_slack(shape, pose, surface.radius);
  Eigen::AlignedBox3d box;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d n = pose.linear().row(axis).transpose();
    const double offset = n.dot(shape.origin) + pose.translation()[axis];
    box.max()[axis] = offset + support(surface, n) + slack;
    box.min()[axis] = offset - support(surface, -n) - slack;
  }
  return box;
}

Eigen::AlignedBox3d ball_box(const Shape& shape, const Eigen::Isometry3d& pose) noexcept {
  const double radius = shape.outer().radius;
  const Eigen::Vector3d centre = pose.linear() * shape.origin + pose.translation();
  // Twice the slack of pose_box(): what contains the exact box contains the rounded one as well.
  const double reach = radius * (1 + 1e-8) + 2 * world_slack(shape, pose, radius);
  return {centre.array() - reach, centre.array() + reach};
}

Eigen::AlignedBox3d world_box(const Shape& shape, const Motion& motion) noexcept {
  if (!is_usable(motion.start) || !is_usable(motion.end)) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {Eigen::Vector3d::Constant(-infinity), Eigen::Vector3d::Constant(infinity)};
  }
  const Eigen::AlignedBox3d start = pose_box(shape, motion.start);
  return motion.at_rest() ? start : start.merged(pose_box(shape, motion.end));
}

}  // namespace encage
