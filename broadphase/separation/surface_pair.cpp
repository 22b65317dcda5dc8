// SPDX-License-Identifier: Apache-2.0
#include "broadphase/separation/surface_pair.h"

#include "broadphase/separation/box_gate.h"
#include "broadphase/separation/leaf_gate.h"
#include "src/limits.h"

#include <cmath>

namespace encage {
namespace {

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
    if (motion.at_rest) return triangles_apart(ta.start, tb.start, distance);
    return effort == Effort::full && moving_triangles_apart(ta, tb, distance);
  }

  bool leaves(std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) const {
    const int ends = motion.at_rest ? 1 : 2;
    const LeafLanes lanes_a = moved(a, motion.a, first_a, count_a, ends);
    const LeafLanes lanes_b = moved(b, motion.b, first_b, count_b, ends);
    for (std::int32_t i = 0; i < count_a; ++i) {
      std::uint32_t left = lanes_not_apart(lanes_a, i, lanes_b, count_b, ends, distance);
      for (; left != 0; left &= left - 1) {
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
                          Effort effort, VisitTriangles visit, void* context) noexcept {
  const BoxGate gate(motion, {a->radius, a->tree.grid, a.scale()}, {b->radius, b->tree.grid, b.scale()}, distance);
  LeafTest test{a, b, motion, distance, effort, visit, context};
  return visit_leaf_pairs(
      a->tree, b->tree, gate,
      [](void* leaf_test, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
        return static_cast<const LeafTest*>(leaf_test)->leaves(first_a, count_a, first_b, count_b);
      },
      &test);
}

bool surfaces_apart(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion,
                    double distance) noexcept {
  const auto stop = [](void*, std::int32_t, std::int32_t) { return false; };
  return visit_intervals(a, b, motion, distance, [&](double t0, double t1) {
    return visit_near_triangles(a, b, motion.part(t0, t1), distance, Effort::full, stop, nullptr);
  });
}

}  // namespace encage
