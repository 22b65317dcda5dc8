// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/self_pairs.h"

#include "broadphase/distance/triangle_distance.h"
#include "src/limits.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace encage {
namespace {

using Point = Eigen::Vector3d;

struct BoxInPlace {
  std::array<float, 3> lower, upper;
};

/// Squares of the distances of eight boxes.
using Squares = std::array<double, MeshNode::width>;

/// Traverses a tree against itself. Boxes are compared in the coordinates in which they bound triangles exactly.
class SelfTraversal {
 public:
  SelfTraversal(const Surface& surface, double reach, VisitSelfPair visit, void* context, std::int64_t& steps)
      : surface_(surface), tree_(surface.tree), visit_(visit), context_(context), steps_(steps) {
    set(reach);
  }

  bool run() { return below(0); }

 private:
  /// A lane of a node.
  struct Lane {
    const MeshNode& node;
    int lane;

    int count() const { return node.count(lane); }
    std::int32_t child() const { return node.child(lane); }
  };

  void set(double reach) {
    // Squares of gaps are off by less than 8 units of roundoff.
    reach_ = reach >= 0 ? reach * reach * (1 + 8 * eps) : -1;
  }
  bool near(double square) const { return square <= reach_; }

  BoxInPlace box(const Lane& at) const {
    BoxInPlace box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lower[axis] = tree_.lower(at.node, axis, at.lane);
      box.upper[axis] = tree_.upper(at.node, axis, at.lane);
    }
    return box;
  }

  static double gap(float lower_a, float upper_a, float lower_b, float upper_b) {
    const double after = static_cast<double>(lower_b) - static_cast<double>(upper_a);
    const double before = static_cast<double>(lower_a) - static_cast<double>(upper_b);
    return std::max({after, before, 0.0});
  }

  Squares squares(const MeshNode& node, const BoxInPlace& other) {
    --steps_;
    Squares sums{};
    for (int axis = 0; axis < 3; ++axis) {
      for (int lane = 0; lane < MeshNode::width; ++lane) {
        const double g =
            gap(tree_.lower(node, axis, lane), tree_.upper(node, axis, lane), other.lower[axis], other.upper[axis]);
        sums[lane] += g * g;
      }
    }
    return sums;
  }

  /// All pairs below a node.
  bool below(std::int32_t n) {
    const MeshNode& node = tree_.nodes[n];
    for (int i = 0; i < MeshNode::width && node.count(i) != MeshNode::unused; ++i) {
      if (node.count(i) == MeshNode::inner ? !below(node.child(i)) : !leaf(node.child(i), node.count(i))) return false;
      const Squares squares_of = squares(node, box({node, i}));
      for (int j = i + 1; j < MeshNode::width && node.count(j) != MeshNode::unused; ++j) {
        if (near(squares_of[j]) && !between({node, i}, {node, j})) return false;
      }
    }
    return true;
  }

  /// All pairs of a triangle below one lane and one below another.
  bool between(const Lane& a, const Lane& b) {
    if (steps_ < 0) return false;
    const bool inner_a = a.count() == MeshNode::inner, inner_b = b.count() == MeshNode::inner;
    if (!inner_a && !inner_b) return leaves(a.child(), a.count(), b.child(), b.count());
    const bool opens_a = inner_a && (!inner_b || larger(a, b));
    const MeshNode& opened = tree_.nodes[opens_a ? a.child() : b.child()];
    const Lane& other = opens_a ? b : a;
    const Squares squares_of = squares(opened, box(other));
    for (int lane = 0; lane < MeshNode::width && opened.count(lane) != MeshNode::unused; ++lane) {
      if (near(squares_of[lane]) && !between({opened, lane}, other)) return false;
    }
    return true;
  }

  static bool larger(const Lane& a, const Lane& b) {
    int of_a = 0, of_b = 0;
    for (int axis = 0; axis < 3; ++axis) {
      of_a = std::max(of_a, a.node.upper[axis][a.lane] - a.node.lower[axis][a.lane]);
      of_b = std::max(of_b, b.node.upper[axis][b.lane] - b.node.lower[axis][b.lane]);
    }
    return of_a >= of_b;
  }

  BoxInPlace box(const LeafTriangle& t) const {
    BoxInPlace box;
    box.lower = box.upper = surface_.mesh.vertices[t.vertices[0]];
    for (const std::int32_t v : t.vertices) {
      for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] = std::min(box.lower[axis], surface_.mesh.vertices[v][axis]);
        box.upper[axis] = std::max(box.upper[axis], surface_.mesh.vertices[v][axis]);
      }
    }
    return box;
  }

  bool triangles(std::int32_t i, const BoxInPlace& box_i, std::int32_t j, const BoxInPlace& box_j) {
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double g = gap(box_i.lower[axis], box_i.upper[axis], box_j.lower[axis], box_j.upper[axis]);
      square += g * g;
    }
    if (!near(square)) return true;
    if (steps_ < 0) return false;
    const LeafTriangle &a = tree_.leaves[i], &b = tree_.leaves[j];
    set(a.triangle < b.triangle ? visit_(context_, a, b) : visit_(context_, b, a));
    return reach_ >= 0;
  }

  bool leaf(std::int32_t first, std::int32_t count) {
    std::array<BoxInPlace, MeshTree::leaf_size + 2> boxes;
    for (std::int32_t i = 0; i < count; ++i) boxes[i] = box(tree_.leaves[first + i]);
    for (std::int32_t i = 0; i < count; ++i) {
      for (std::int32_t j = i + 1; j < count; ++j) {
        if (!triangles(first + i, boxes[i], first + j, boxes[j])) return false;
      }
    }
    return true;
  }

  bool leaves(std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
    std::array<BoxInPlace, MeshTree::leaf_size + 2> boxes;
    for (std::int32_t j = 0; j < count_b; ++j) boxes[j] = box(tree_.leaves[first_b + j]);
    for (std::int32_t i = 0; i < count_a; ++i) {
      const BoxInPlace box_i = box(tree_.leaves[first_a + i]);
      for (std::int32_t j = 0; j < count_b; ++j) {
        if (!triangles(first_a + i, box_i, first_b + j, boxes[j])) return false;
      }
    }
    return true;
  }

  const Surface& surface_;
  const MeshTreeView& tree_;
  VisitSelfPair visit_;
  void* context_;
  std::int64_t& steps_;
  double reach_ = 0;
};

/// Signs of products of two or three vectors that are off by eps of their norms: 32 units of roundoff bound inputs,
/// products and sums.
constexpr double product_error = 16 * eps;

/// True if no vertex is needed to part the triangles but the one that they share, the origin here: a plane through it
/// has one on each side. The normal may be anything; that between the directions of the triangles serves in most fans.
bool parted_at(const std::array<Point, 2>& a, const std::array<Point, 2>& b) {
  const Point n = (a[0] + a[1]).normalized() - (b[0] + b[1]).normalized();
  const double length = n.norm();
  for (int k = 0; k < 2; ++k) {
    if (!(n.dot(a[k]) > product_error * length * a[k].norm())) return false;
    if (!(n.dot(b[k]) < -product_error * length * b[k].norm())) return false;
  }
  return true;
}

/// True if triangles that share an edge are proven not to lie on each other: they are in different planes, or on
/// different sides of it.
bool parted_along(const Point& edge, const Point& a, const Point& b) {
  const Point normal_a = edge.cross(a), normal_b = edge.cross(b);
  const double sizes = edge.norm() * a.norm() * b.norm();
  return normal_a.dot(normal_b) < -product_error * edge.norm() * sizes ||
         std::abs(edge.dot(a.cross(b))) > product_error * sizes;
}

}  // namespace

SelfPair self_pair(const Surface& surface, const LeafTriangle& a, const LeafTriangle& b) noexcept {
  SelfPair pair;
  for (auto& points : pair.other) points.fill(Point::Zero());
  pair.common.fill(Point::Zero());
  pair.a = a.triangle;
  pair.b = b.triangle;
  const auto has = [](const LeafTriangle& t, std::int32_t v) {
    return std::ranges::find(t.vertices, v) != t.vertices.end();
  };
  // The first shared vertex is the origin, if there is one.
  std::int32_t origin = a.vertices[0];
  for (int k = 2; k >= 0; --k) {
    if (has(b, a.vertices[k])) origin = a.vertices[k];
  }
  pair.origin = surface.vertex(origin);
  const auto place = [&](std::int32_t v) -> Point { return surface.vertex(v) - pair.origin; };
  for (int k = 0; k < 3; ++k) {
    pair.corners_a[k] = place(a.vertices[k]);
    pair.corners_b[k] = place(b.vertices[k]);
    pair.size = std::max({pair.size, pair.corners_a[k].norm(), pair.corners_b[k].norm()});
  }
  const auto sort = [&](const LeafTriangle& t, const LeafTriangle& from, std::size_t side) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t v = t.vertices[k];
      if (std::find(t.vertices.begin(), t.vertices.begin() + static_cast<std::ptrdiff_t>(k), v) !=
          t.vertices.begin() + static_cast<std::ptrdiff_t>(k)) {
        continue;  // a repeated vertex
      }
      if (!has(from, v)) {
        const auto n = static_cast<std::size_t>(pair.others[side]++);
        if (n < 2) pair.other[side][n] = place(v);
        if (n == 0) pair.other[side][1] = pair.other[side][0];
      } else if (side == 0) {
        if (pair.shared < 2) pair.common[static_cast<std::size_t>(pair.shared)] = place(v);
        ++pair.shared;
      }
    }
  };
  sort(a, b, 0);
  sort(b, a, 1);
  return pair;
}

bool only_share(const SelfPair& pair) noexcept {
  // Projections are off by 4 eps of a corner for each triangle, and corners by less than eps.
  const double required = 16 * eps * pair.size + 1e-60;
  if (pair.shared == 0) return triangles_apart(pair.corners_a, pair.corners_b, required);
  // A triangle that has no vertex of its own is an edge or a corner of the other one, or both are the same.
  if (pair.others[0] == 0 || pair.others[1] == 0) return pair.shared < 3;
  if (pair.shared == 2) return parted_along(pair.common[1] - pair.common[0], pair.other[0][0], pair.other[1][0]);
  if (parted_at(pair.other[0], pair.other[1])) return true;
  // What they have in common besides the shared corner reaches an edge opposite to it.
  const auto opposite = [&](std::size_t side) -> TriangleD {
    return {pair.other[side][0], pair.other[side][1], pair.other[side][1]};
  };
  return triangles_apart(opposite(0), pair.corners_b, required) &&
         triangles_apart(pair.corners_a, opposite(1), required);
}

bool certainly_meet(const SelfPair& pair) noexcept {
  if (pair.shared == 3) return true;
  return pair.shared < 2 && triangles_cross(pair.corners_a, pair.corners_b, eps * pair.size);
}

bool visit_self_pairs(const Surface& surface, double reach, VisitSelfPair visit, void* context,
                      std::int64_t& steps) noexcept {
  return SelfTraversal(surface, reach, visit, context, steps).run();
}

}  // namespace encage
