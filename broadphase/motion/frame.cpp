// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/frame.h"

#include "broadphase/motion/turned_box.h"
#include "broadphase/shape/compound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace encage {
namespace {

// Twice the unit roundoff: the bounds below are counted in it, with room to spare.
constexpr double eps = std::numeric_limits<double>::epsilon();

/// Covers the rounding of a world coordinate and the error of the fine vertices.
double world_slack(const Shape& shape, const Placement& at, double radius) {
  const double size = at.scale * (radius + shape.origin.norm()) + at.pose.translation().norm();
  return 32 * eps * size + (1 + 1e-8) * at.scale * shape.outer_error();
}

}  // namespace

double departure_from_rigid(const Eigen::Matrix3d& linear) noexcept {
  // Entries of the product are off by at most 3 eps for lengths near 1; the
  // Frobenius norm of nine such errors stays below 16 eps.
  return (linear.transpose() * linear - Eigen::Matrix3d::Identity()).norm() * (1 + 16 * eps) + 16 * eps;
}

bool is_usable(const Eigen::Isometry3d& pose) noexcept {
  return pose.translation().cwiseAbs().maxCoeff() <= largest_length && pose.translation().allFinite() &&
         departure_from_rigid(pose.linear()) <= 1e-9;
}

// A box is skipped if its bound is no larger than one at hand; both carry that error.
double support(const Surface& surface, const Eigen::Vector3d& n, double tolerance) noexcept {
  struct Entry {
    std::int32_t node;
    double bound;
  };
  // What some vertex reaches, and what may be reached at most.
  double reached = -std::numeric_limits<double>::infinity(), bound = reached;
  const Eigen::Vector3d magnitude = n.cwiseAbs();
  std::array<Entry, MeshNode::width*(MeshTree::max_depth + 2)> stack;
  int size = 0;
  stack[size++] = {0, std::numeric_limits<double>::infinity()};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.bound <= bound) continue;
    const MeshNode& node = surface.tree.nodes[entry.node];
    const int below = size;
    std::array<double, MeshNode::width> uppers{}, widths{};
    for (int k = 0; k < 3; ++k) {
      for (int lane = 0; lane < MeshNode::width; ++lane) {
        const double low = surface.tree.lower(node, k, lane), high = surface.tree.upper(node, k, lane);
        uppers[lane] += n[k] * (n[k] > 0 ? high : low);
        widths[lane] += magnitude[k] * (high - low);
      }
    }
    for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
      const double upper = uppers[lane], width = widths[lane];
      if (upper <= bound) continue;
      // Every box holds a vertex: the lower end is reached.
      reached = std::max(reached, upper - width);
      if (width <= tolerance || upper <= reached + tolerance) {
        bound = upper;
      } else if (node.count(lane) == MeshNode::inner) {
        stack[size++] = {node.child(lane), upper};
      } else {
        for (std::int32_t i = node.child(lane); i < node.child(lane) + node.count(lane); ++i) {
          for (const std::int32_t v : surface.tree.leaves[i].vertices) {
            bound = std::max(bound, n.dot(surface.vertex(v)));
          }
        }
        reached = std::max(reached, bound);
      }
    }
    // The most promising one next.
    std::sort(stack.begin() + below, stack.begin() + size,
              [](const Entry& x, const Entry& y) { return x.bound < y.bound; });
  }
  return bound;
}

bool is_usable(const Motion& motion) noexcept {
  if (!is_usable(motion.start) || !is_usable(motion.end)) return false;
  if (!(motion.scale >= 1e-50 && motion.scale <= 1e50)) return false;
  // 1 + 2 cos of the angle between the poses; off by no more than their departure from rigid and rounding.
  return (motion.start.linear().transpose() * motion.end.linear()).trace() > -1 + 1e-6;
}

// Large coordinates that both have cancel first.
Eigen::Vector3d origin_offset(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b) noexcept {
  return (at_b.pose.translation() - at_a.pose.translation()) +
         (at_b.pose.linear() * (at_b.scale * b.origin) - at_a.pose.linear() * (at_a.scale * a.origin));
}

PairFrame relative_frame(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b) noexcept {
  const Eigen::Matrix3d to_a = at_a.pose.linear().transpose();
  return {to_a * at_b.pose.linear(), to_a * origin_offset(a, at_a, b, at_b)};
}

double required_distance(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b,
                         double margin) noexcept {
  const double size = at_a.scale * (a.radius + a.origin.norm()) + at_b.scale * (b.radius + b.origin.norm()) +
                      at_a.pose.translation().norm() + at_b.pose.translation().norm();
  const double departure = departure_from_rigid(at_a.pose.linear()) + departure_from_rigid(at_b.pose.linear());
  return margin * (1 + 64 * eps + 4 * departure) + (256 * eps + 32 * departure) * size;
}

bool boxes_apart(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b, double margin) noexcept {
  if (a.isEmpty() || b.isEmpty()) return false;
  const Eigen::Array3d gap = (b.min() - a.max()).array().max((a.min() - b.max()).array()).max(0.0);
  // Each gap and the norm are off by a few eps relatively.
  const double largest = gap.maxCoeff();
  return largest > 0 && std::isfinite(largest) && (gap / largest).matrix().norm() * largest * (1 - 16 * eps) > margin;
}

Eigen::AlignedBox3d pose_box(const Shape& shape, const Placement& at) noexcept {
  const Surface& surface = shape.outer();
  const Eigen::Vector3d centre = at.origin(shape);
  Eigen::Vector3d low, high;
  double slack = world_slack(shape, at, surface.radius);
  if (!shape.outline.empty()) {
    shape.outline.extents(at.pose.linear(), low, high);
    slack += 0x1p-20 * at.scale * shape.outline_radius;
  } else {
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d n = at.pose.linear().row(axis).transpose();
      const double tolerance = 0x1p-8 * surface.radius;
      low[axis] = -support(surface, -n, tolerance);
      high[axis] = support(surface, n, tolerance);
    }
  }
  const Eigen::Vector3d farthest = Eigen::Vector3d::Constant(surface.radius * (1 + 1e-8));
  return {centre + at.scale * low.cwiseMax(-farthest) - Eigen::Vector3d::Constant(slack),
          centre + at.scale * high.cwiseMin(farthest) + Eigen::Vector3d::Constant(slack)};
}

Eigen::AlignedBox3d ball_box(const Shape& shape, const Placement& at) noexcept {
  if (!shape.parts.empty()) return turned_box(shape.part_nodes.front().box, at.pose, at.scale);
  const double radius = shape.outer().radius;
  const Eigen::Vector3d centre = at.origin(shape);
  // Twice the slack of pose_box(): what contains the exact box contains the rounded one as well.
  const double reach = at.scale * radius * (1 + 1e-8) + 2 * world_slack(shape, at, radius);
  return {centre.array() - reach, centre.array() + reach};
}

Eigen::AlignedBox3d world_box(const Shape& shape, const Motion& motion) noexcept {
  if (!is_usable(motion)) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return {Eigen::Vector3d::Constant(-infinity), Eigen::Vector3d::Constant(infinity)};
  }
  return usable_box(shape, motion);
}

Eigen::AlignedBox3d usable_box(const Shape& shape, const Motion& motion) noexcept {
  if (!shape.parts.empty()) return compound_box(shape, motion);
  const Eigen::AlignedBox3d start = pose_box(shape, {motion.start, motion.scale});
  return motion.at_rest() ? start : start.merged(pose_box(shape, {motion.end, motion.scale}));
}

}  // namespace encage
