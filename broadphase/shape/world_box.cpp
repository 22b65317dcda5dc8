// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/world_box.h"

#include "broadphase/motion/turned_box.h"
#include "broadphase/shape/compound.h"
#include "src/limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace encage {
namespace {

/// Covers the rounding of a world coordinate and the error of the fine vertices.
double world_slack(const SimpleShape& shape, const Placement& at, double radius) {
  const double size = at.scale * (radius + shape.frame.origin.norm()) + at.pose.translation().norm();
  return 32 * eps * size + shape.error_in_world(at.scale);
}

/// The union of the parts' boxes if there are few, the turned box of the compound if there are many.
Eigen::AlignedBox3d compound_box(const CompoundShape& compound, const Motion& motion) noexcept {
  constexpr std::size_t few = 32;
  if (compound.parts.size() > few) return swept_box(compound.nodes.front().box, motion);
  Eigen::AlignedBox3d all;
  for (std::size_t i = 0; i < compound.parts.size(); ++i) {
    const MovingPart part = moving_part(compound, i, motion);
    const Eigen::AlignedBox3d box = world_box(*part.shape, part.motion);
    all.extend(box.min() - Eigen::Vector3d::Constant(part.slack))
        .extend(box.max() + Eigen::Vector3d::Constant(part.slack));
  }
  return all;
}

}  // namespace

// A box is skipped if its bound is no larger than the present bound; both carry the same rounding error.
double support(const Surface& surface, const Eigen::Vector3d& n, double tolerance) noexcept {
  struct Entry {
    std::int32_t node;
    double bound;
  };
  // Some vertex has at least the height `reached`; `bound` is an upper bound for the boxes that need no further visit.
  double reached = -infinity, bound = reached;
  const Eigen::Vector3d magnitude = n.cwiseAbs();
  std::array<Entry, MeshNode::width*(MeshTree::max_depth + 2)> stack;
  int size = 0;
  stack[size++] = {0, infinity};
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
      // Every box contains a vertex, so some height is at least that of its lower end.
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
    // The most promising box comes next.
    std::sort(stack.begin() + below, stack.begin() + size,
              [](const Entry& x, const Entry& y) { return x.bound < y.bound; });
  }
  return bound;
}

Eigen::AlignedBox3d pose_box(const SimpleShape& shape, const Placement& at) noexcept {
  const Surface& surface = shape.outer();
  const Eigen::Vector3d centre = at.origin(shape.frame);
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
  if (shape.is_compound()) return turned_box(shape.compound().nodes.front().box, at.pose, at.scale);
  const SimpleShape& simple = shape.simple();
  const double radius = simple.outer().radius;
  const Eigen::Vector3d centre = at.origin(simple.frame);
  // Twice the slack of pose_box(): a box that contains the exact box then also contains the rounded one.
  const double reach = at.scale * radius * (1 + 1e-8) + 2 * world_slack(simple, at, radius);
  return {centre.array() - reach, centre.array() + reach};
}

Eigen::AlignedBox3d world_box(const Shape& shape, const Motion& motion) noexcept {
  if (!is_usable(motion)) {
    return {Eigen::Vector3d::Constant(-infinity), Eigen::Vector3d::Constant(infinity)};
  }
  return usable_box(shape, motion);
}

Eigen::AlignedBox3d usable_box(const Shape& shape, const Motion& motion) noexcept {
  if (shape.is_compound()) return compound_box(shape.compound(), motion);
  const SimpleShape& simple = shape.simple();
  const Eigen::AlignedBox3d start = pose_box(simple, {motion.start, motion.scale});
  return motion.at_rest() ? start : start.merged(pose_box(simple, {motion.end, motion.scale}));
}

}  // namespace encage
