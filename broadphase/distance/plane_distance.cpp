// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pose.h"
#include "broadphase/shape/compound.h"
#include "src/limits.h"
#include "src/tree/visit.h"

#include <encage/distance.h>
#include <encage/fine_lease.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// The vertex of a surface that is lowest along a direction; of equally low ones the first. -1 if none is below the
/// limit.
struct LowestVertex {
  double height = infinity;
  std::int32_t vertex = -1;
};

LowestVertex lowest_vertex(const Surface& surface, const Vector& n, double limit) noexcept {
  struct Entry {
    std::int32_t node;
    double bound;
  };
  // Bounds of boxes and heights are off by less: no vertex that is lowest as computed is left out.
  const double slack = 16 * eps * surface.radius;
  LowestVertex lowest{limit, -1};
  const auto consider = [&](std::int32_t v) {
    const double height = n.dot(surface.vertex(v));
    if (height > lowest.height || (height == lowest.height && (lowest.vertex < 0 || v > lowest.vertex))) return;
    lowest = {height, v};
  };
  std::array<Entry, traversal_stack_size> stack;
  int size = 0;
  stack[size++] = {0, -infinity};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.bound > lowest.height + slack) continue;
    const MeshNode& node = surface.tree.nodes[entry.node];
    std::array<double, MeshNode::width> lower{};
    for (int k = 0; k < 3; ++k) {
      for (int lane = 0; lane < MeshNode::width; ++lane) {
        const float x = n[k] > 0 ? surface.tree.lower(node, k, lane) : surface.tree.upper(node, k, lane);
        lower[lane] += n[k] * static_cast<double>(x);
      }
    }
    const int below = size;
    for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
      if (lower[lane] > lowest.height + slack) continue;
      if (node.count(lane) == MeshNode::inner) {
        stack[size++] = {node.child(lane), lower[lane]};
        continue;
      }
      for (std::int32_t i = node.child(lane); i < node.child(lane) + node.count(lane); ++i) {
        for (const std::int32_t v : surface.tree.leaves[i].vertices) consider(v);
      }
    }
    // The lowest box comes next.
    std::sort(stack.begin() + below, stack.begin() + size,
              [](const Entry& x, const Entry& y) { return x.bound > y.bound; });
  }
  return lowest;
}

/// A part above a plane. Heights are those above the plane, in world units.
class PartAbove {
 public:
  PartAbove(const MovingPart& part, const HalfSpace& plane)
      : part_(part), normal_(part.motion.start.linear().transpose() * plane.normal), length_(plane.normal.norm()) {
    const Eigen::Isometry3d& pose = part.motion.start;
    const LocalFrame& frame = part.shape->frame;
    const double scale = part.motion.scale;
    height_ = plane.normal.dot(pose * (scale * frame.origin)) - plane.offset;
    // Heights are off by less than 16 units of roundoff of the sizes, their quotients by the length by 4 more.
    error_ = 32 * eps * (std::abs(plane.offset) + scale * frame.reach() + pose.translation().norm()) + part.slack;
  }

  /// No vertex is lower.
  double ball_bound() const { return (height_ - part_.motion.scale * radius() * (1 + 1e-8)) / length_ - error_; }

  /// Bounds the height of the lowest vertex of a surface, if that is not proven to be `limit` or more.
  LowestVertex lowest(const Surface& surface, double limit) const {
    const double local = ((limit + 2 * error_) * length_ - height_) / part_.motion.scale;
    LowestVertex found = lowest_vertex(surface, normal_, local);
    // Then all are higher than the limit and the error.
    found.height = found.vertex < 0 ? limit + error_ : (height_ + part_.motion.scale * found.height) / length_;
    return found;
  }

  double error() const { return error_; }

 private:
  double radius() const { return part_.shape->outer().radius; }

  const MovingPart& part_;
  Vector normal_;  ///< in the local frame
  double length_;  ///< of the plane's normal
  double height_;  ///< of the local origin, times that length
  double error_;
};

/// distance() of one part.
PlaneDistance part_distance(const MovingPart& part, const HalfSpace& plane, double limit) {
  const SimpleShape& shape = *part.shape;
  const PartAbove above(part, plane);
  const double fine_error = shape.error_in_world(part.motion.scale);
  if (const double bound = above.ball_bound() - fine_error; bound >= limit) return {.lower = bound};
  const auto cage_bound = [&] { return above.lowest(shape.cages.front(), limit).height - above.error(); };
  if (!shape.has_fine()) return {.lower = cage_bound()};
  if (shape.on_demand && limit < infinity) {
    if (const double bound = cage_bound(); bound >= limit) return {.lower = bound};
  }
  FineLease lease;
  if (!lease.take(shape)) return {.lower = cage_bound()};
  const LowestVertex found = above.lowest(shape.fine, limit + fine_error);
  const double error = above.error() + fine_error;
  PlaneDistance result{.lower = found.height - error};
  if (found.vertex < 0) return result;
  const double scale = part.motion.scale;
  result.upper = found.height - shape.least_radius(scale) + above.error() + shape.core_error_in_world(scale);
  const Vector normal = plane.normal.normalized();
  const Vector vertex = part.motion.start * (scale * (shape.frame.origin + shape.fine.vertex(found.vertex)));
  result.point = vertex - scale * shape.convex_radius * normal;
  result.foot = vertex - found.height * normal;
  result.vertex = part.first_vertex + found.vertex;
  return result;
}

bool can_be_asked(const HalfSpace& plane) {
  return std::abs(plane.normal.norm() - 1) <= rigid_tolerance && std::isfinite(plane.offset);
}

}  // namespace

PlaneDistance distance(const Shape& shape, const Motion& motion, const HalfSpace& half_space,
                       const PlaneDistanceOptions& options) noexcept {
  const Motion at = Motion::resting(motion.start, motion.scale);
  if (!is_usable(at) || !can_be_asked(half_space) || std::isnan(options.limit)) return {};
  PlaneDistance lowest{.lower = options.limit};
  for_each_part(shape, at, [&](const MovingPart& part) {
    const PlaneDistance found = part_distance(part, half_space, std::min(options.limit, lowest.upper));
    const double lower = std::min(lowest.lower, found.lower);
    if (found.upper < lowest.upper) lowest = found;
    lowest.lower = lower;
    return true;
  });
  return lowest.lower >= options.limit ? PlaneDistance{.lower = options.limit} : lowest;
}

}  // namespace encage
