// SPDX-License-Identifier: Apache-2.0
#include "broadphase/surface_pair.h"

#include "broadphase/box_gate.h"

#include <cmath>

namespace encage {
namespace {

/// The corners at the start, and at the end if there is another one.
void move(const Surface& surface, const std::array<AffineMap, 2>& maps, const LeafTriangle& triangle, int ends,
          MovingTriangle& moved) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d x = surface.vertex(triangle.vertices[k]);
    moved.start[k] = maps[0](x);
    if (ends == 2) moved.end[k] = maps[1](x);
  }
}

/// A triangle, and its box at both ends.
struct MovedTriangle {
  MovingTriangle corners;
  std::array<Eigen::Array3d, 2> low, high;

  void bound(int ends) {
    for (int end = 0; end < ends; ++end) {
      const TriangleD& t = end == 0 ? corners.start : corners.end;
      low[end] = t[0].array().min(t[1].array()).min(t[2].array());
      high[end] = t[0].array().max(t[1].array()).max(t[2].array());
    }
  }

  /// True only if a coordinate axis separates the boxes by more than `distance` at all ends, in the same sense.
  bool apart(const MovedTriangle& other, int ends, double distance) const {
    Eigen::Array3d above = low[0] - other.high[0], below = other.low[0] - high[0];
    if (ends == 2) {
      above = above.min(low[1] - other.high[1]);
      below = below.min(other.low[1] - high[1]);
    }
    return (above > distance).any() || (below > distance).any();
  }
};

/// Tests the triangles of pairs of leaves.
struct LeafTest {
  const Surface& a;
  const Surface& b;
  const PairMotion& motion;
  double distance;
  Effort effort;
  VisitTriangles visit;
  void* context;

  bool apart(const MovedTriangle& ta, const MovedTriangle& tb, int ends) const {
    if (ta.apart(tb, ends, distance)) return true;
    if (motion.at_rest) return triangles_apart(ta.corners.start, tb.corners.start, distance);
    return quickly_apart(ta.corners, tb.corners, distance) ||
           (effort == Effort::full && moving_triangles_apart(ta.corners, tb.corners, distance));
  }

  bool leaves(std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) const {
    const int ends = motion.at_rest ? 1 : 2;
    std::array<MovedTriangle, WideTree::leaf_size> moved;
    for (std::int32_t i = 0; i < count_a; ++i) {
      move(a, motion.a, a.tree.leaves[first_a + i], ends, moved[i].corners);
      moved[i].bound(ends);
    }
    for (std::int32_t j = first_b; j < first_b + count_b; ++j) {
      MovedTriangle tb;
      move(b, motion.b, b.tree.leaves[j], ends, tb.corners);
      tb.bound(ends);
      for (std::int32_t i = 0; i < count_a; ++i) {
        if (apart(moved[i], tb, ends)) continue;
        if (!visit(context, a.tree.leaves[first_a + i].triangle, b.tree.leaves[j].triangle)) return false;
      }
    }
    return true;
  }
};

}  // namespace

MovingTriangle moving_triangle(const Surface& surface, const std::array<AffineMap, 2>& maps,
                               const LeafTriangle& triangle) noexcept {
  MovingTriangle moved;
  move(surface, maps, triangle, 2, moved);
  return moved;
}

bool balls_apart(const Surface& a, const Surface& b, const PairMotion& motion, double distance) noexcept {
  const Eigen::Vector3d start = motion.b[0].offset - motion.a[0].offset, end = motion.b[1].offset - motion.a[1].offset;
  const Eigen::Vector3d axis = start + end;
  // Twice: room for rounding of the radii's images; what it costs is nothing.
  const double required = (a.radius + b.radius) * (1 + 1e-8) + 2 * distance;
  const double scaled = axis.norm() * required;
  return scaled > 1e-280 && axis.dot(start) > scaled && axis.dot(end) > scaled;
}

bool visit_near_triangles(const Surface& a, const Surface& b, const PairMotion& motion, double distance, Effort effort,
                          VisitTriangles visit, void* context) noexcept {
  const BoxGate gate(motion, {a.radius, a.tree.grid}, {b.radius, b.tree.grid}, distance);
  LeafTest test{a, b, motion, distance, effort, visit, context};
  return visit_leaf_pairs(
      a.tree, b.tree, gate,
      [](void* leaf_test, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
        return static_cast<const LeafTest*>(leaf_test)->leaves(first_a, count_a, first_b, count_b);
      },
      &test);
}

bool surfaces_apart(const Surface& a, const Surface& b, const PairMotion& motion, double distance) noexcept {
  const auto stop = [](void*, std::int32_t, std::int32_t) { return false; };
  return visit_intervals(a, b, motion, distance, [&](double t0, double t1) {
    return visit_near_triangles(a, b, motion.part(t0, t1), distance, Effort::full, stop, nullptr);
  });
}

}  // namespace encage
