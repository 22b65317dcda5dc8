// SPDX-License-Identifier: Apache-2.0
#include "broadphase/separation/surface_pair.h"

#include "broadphase/separation/box_gate.h"
#include "broadphase/separation/leaf_gate.h"
#include "src/limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage {
namespace {

// Tests of boxes against eight that take as long as the test of a triangle against eight, and of two triangles in full.
constexpr std::int64_t steps_of_row = 2, steps_of_triangles = 16;

/// Computes the corners at the start, and at the end if `ends` is 2.
void move(const ScaledSurface& surface, const std::array<AffineMap, 2>& maps, const LeafTriangle& triangle, int ends,
          MovingTriangle& moved) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d x = surface.vertex(triangle.vertices[k]);
    moved.start[k] = maps[0](x);
    if (ends == 2) moved.end[k] = maps[1](x);
  }
}

/// Tests the triangles of pairs of leaves against each other.
struct LeafTest {
  const ScaledSurface& a;
  const ScaledSurface& b;
  const PairMotion& motion;
  double distance;
  Effort effort;
  VisitTriangles visit;
  void* context;
  std::int64_t& steps;

  static LeafLanes moved(const ScaledSurface& surface, const std::array<AffineMap, 2>& maps, std::int32_t first,
                         std::int32_t count, int ends) {
    LeafLanes lanes;
    MovingTriangle triangle;
    for (std::int32_t i = 0; i < LeafLanes::width; ++i) {
      if (i < count) move(surface, maps, surface->tree.leaves[first + i], ends, triangle);
      lanes.set(i, triangle, ends);
    }
    return lanes;
  }

  /// Tests the pairs that lanes_not_apart() leaves.
  bool apart(const MovingTriangle& ta, const MovingTriangle& tb) const {
    if (motion.at_rest) {
      steps -= steps_of_triangles;
      return triangles_apart(ta.start, tb.start, distance);
    }
    if (effort != Effort::full) return false;
    int pieces = 0;
    const bool result = moving_triangles_apart(ta, tb, distance, pieces);
    steps -= steps_of_triangles * pieces;
    return result;
  }

  bool leaves(std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) const {
    const int ends = motion.at_rest ? 1 : 2;
    steps -= steps_of_row * count_a;
    const LeafLanes lanes_a = moved(a, motion.a, first_a, count_a, ends);
    const LeafLanes lanes_b = moved(b, motion.b, first_b, count_b, ends);
    for (std::int32_t i = 0; i < count_a; ++i) {
      std::uint32_t left = lanes_not_apart(lanes_a, i, lanes_b, count_b, ends, distance);
      for (; left != 0; left &= left - 1) {
        if (steps < 0) return false;
        const int j = __builtin_ctz(left);
        if (apart(lanes_a.triangle(i, ends), lanes_b.triangle(j, ends))) continue;
        if (!visit(context, a->tree.leaves[first_a + i].triangle, b->tree.leaves[first_b + j].triangle)) return false;
      }
    }
    return true;
  }
};

}  // namespace

MovingTriangle moving_triangle(const ScaledSurface& surface, const std::array<AffineMap, 2>& maps,
                               const LeafTriangle& triangle) noexcept {
  MovingTriangle moved;
  move(surface, maps, triangle, 2, moved);
  return moved;
}

bool balls_apart(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion, double distance) noexcept {
  const Eigen::Vector3d start = motion.b[0].offset - motion.a[0].offset, end = motion.b[1].offset - motion.a[1].offset;
  const Eigen::Vector3d axis = start + end;
  // The distance counts twice, which leaves room for the rounding of the images of the radii at no cost.
  const double required = (a.radius() + b.radius()) * (1 + 1e-8) + 2 * distance;
  const double scaled = axis.norm() * required;
  return scaled > smallest_square && axis.dot(start) > scaled && axis.dot(end) > scaled;
}

bool visit_near_triangles(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion, double distance,
                          Effort effort, VisitTriangles visit, void* context, std::int64_t* steps) noexcept {
  std::int64_t unlimited = std::numeric_limits<std::int64_t>::max();
  if (steps == nullptr) steps = &unlimited;
  const BoxGate gate(motion, {a->radius, a->tree.grid, a.scale()}, {b->radius, b->tree.grid, b.scale()}, distance,
                     effort == Effort::quick);
  LeafTest test{a, b, motion, distance, effort, visit, context, *steps};
  return visit_leaf_pairs(
      a->tree, b->tree, gate,
      [](void* leaf_test, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
        return static_cast<const LeafTest*>(leaf_test)->leaves(first_a, count_a, first_b, count_b);
      },
      &test, steps);
}

namespace {

/// Proves surfaces apart in intervals. Boxes prove the less the longer an interval is: one that takes long is halved.
/// Its halves may take four times as long, since where surfaces are near each other for long, halves cost as much as
/// the whole.
class IntervalProof {
 public:
  IntervalProof(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion, double distance,
                std::int64_t& steps)
      : a_(a), b_(b), motion_(motion), distance_(distance), steps_(steps) {}

  bool apart(double t0, double t1, std::int64_t most_steps = 1 << 14) {
    const bool last = motion_.at_rest || most_steps >= steps_;
    const std::int64_t allowed = last ? steps_ : most_steps;
    std::int64_t left = allowed;
    bool near = false;
    const bool proven = visit_near_triangles(
        a_, b_, motion_.part(t0, t1), distance_, Effort::full,
        [](void* found, std::int32_t, std::int32_t) {
          *static_cast<bool*>(found) = true;
          return false;
        },
        &near, &left);
    steps_ -= allowed - left;
    if (proven || near || last || steps_ < 0) return proven;
    const double middle = 0.5 * (t0 + t1);
    return apart(t0, middle, 4 * most_steps) && apart(middle, t1, 4 * most_steps);
  }

 private:
  const ScaledSurface& a_;
  const ScaledSurface& b_;
  const PairMotion& motion_;
  double distance_;
  std::int64_t& steps_;
};

}  // namespace

bool surfaces_apart(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion, double distance,
                    std::int64_t* steps) noexcept {
  std::int64_t unlimited = std::numeric_limits<std::int64_t>::max();
  IntervalProof proof(a, b, motion, distance, steps == nullptr ? unlimited : *steps);
  return visit_intervals(a, b, motion, distance, [&](double t0, double t1) { return proof.apart(t0, t1); });
}

}  // namespace encage
