// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/nesting.h"

#include "cagegen/certify/separation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace encage::proof {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
/// Sums of squares below may have lost their relative accuracy to underflow.
constexpr double smallest_square = 1e-280;
/// Depth of a median-split tree over 2^31 triangles, with room.
using Stack = std::array<std::int32_t, 64>;

bool boxes_meet(const BoxTree::Node& a, const BoxTree::Node& b) {
  for (int k = 0; k < 3; ++k) {
    if (a.low[k] > b.high[k] || b.low[k] > a.high[k]) return false;
  }
  return true;
}

BoxTree::Node box_of(const Corners& t) {
  BoxTree::Node box{};
  for (int k = 0; k < 3; ++k) {
    box.low[k] = std::min({t[0][k], t[1][k], t[2][k]});
    box.high[k] = std::max({t[0][k], t[1][k], t[2][k]});
  }
  return box;
}

double squared_gap(const BoxTree::Node& a, const BoxTree::Node& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double gap = std::max({0.0, a.low[k] - b.high[k], b.low[k] - a.high[k]});
    sum += gap * gap;
  }
  return sum;
}

double common_extent(const BoxTree::Node& a, const BoxTree::Node& b) {
  double extent = 0;
  for (int k = 0; k < 3; ++k) extent = std::max(extent, std::max(a.high[k], b.high[k]) - std::min(a.low[k], b.low[k]));
  return extent;
}

// ---- Self-intersection ------------------------------------------------------

/// Do two triangles have more in common than their shared vertices?
bool overlap(const TriangleMesh& mesh, std::int32_t s, std::int32_t t) {
  int shared = 0;
  int in_s = 0, in_t = 0;      // sums of the corners that are shared
  int last_s = 0, last_t = 0;  // one of them
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (mesh.triangles(s, i) != mesh.triangles(t, j)) continue;
      ++shared;
      in_s += last_s = i;
      in_t += last_t = j;
    }
  }
  const Corners a = corners(mesh, s);
  const Corners b = corners(mesh, t);
  switch (shared) {
    case 0: return separate(a, b).lower == 0 && touch(a, b);
    case 1:
      return overlap_at_vertex(a[last_s], a[(last_s + 1) % 3], a[(last_s + 2) % 3], b[(last_t + 1) % 3],
                               b[(last_t + 2) % 3]);
    case 2: {
      const int apex_s = 3 - in_s;
      const int apex_t = 3 - in_t;
      return overlap_at_edge(a[(apex_s + 1) % 3], a[(apex_s + 2) % 3], a[apex_s], b[apex_t]);
    }
    default: return true;
  }
}

/// The first triangle after t, in the order of the tree, that overlaps it.
std::int32_t overlapping(const Surface& surface, std::int32_t t) {
  const BoxTree& tree = surface.tree;
  const BoxTree::Node box = box_of(corners(surface.mesh, t));
  Stack stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const BoxTree::Node& node = tree.nodes[stack[--top]];
    if (!boxes_meet(node, box)) continue;
    if (node.count == 0) {
      stack[top++] = node.first + 1;
      stack[top++] = node.first;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const std::int32_t other = tree.order[i];
      if (other > t && boxes_meet(box_of(corners(surface.mesh, other)), box) && overlap(surface.mesh, t, other)) {
        return other;
      }
    }
  }
  return -1;
}

// ---- Contact and clearance --------------------------------------------------

/// Branch and bound for the distance of two surfaces, one outer triangle at a time.
class ContactSearch {
 public:
  ContactSearch(const Surface& inner, const Surface& outer) : inner_(inner), outer_(outer) {}

  Contact run() {
    for (const std::int32_t t : outer_.tree.order) {
      visit(t);
      if (found_.clearance == 0) break;
    }
    return found_;
  }

 private:
  /// The outer triangle at hand: box, and slab between two parallels to its plane.
  struct Query {
    std::int32_t triangle;
    Corners corners;
    BoxTree::Node box;
    Point normal;  ///< of length about 1, or 0 if double cannot tell
    double low, high;
    double extent;

    Query(const TriangleMesh& mesh, std::int32_t t)
        : triangle(t), corners(proof::corners(mesh, t)), box(box_of(corners)), low(0), high(0), extent(0) {
      const Point cross = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
      const double length = cross.norm();
      normal = length > 1e-140 && length < 1e200 ? Point(cross / length) : Point::Zero();
      for (int k = 1; k < 3; ++k) {
        const Point relative = corners[k] - corners[0];
        const double height = normal.dot(relative);
        low = std::min(low, height);
        high = std::max(high, height);
        extent = std::max(extent, relative.lpNorm<Eigen::Infinity>());
      }
    }

    /// Proven distance of the slab from a box.
    double slab_distance(const BoxTree::Node& node) const {
      double bottom = 0, top = 0, reach = extent;
      for (int k = 0; k < 3; ++k) {
        const double near = node.low[k] - corners[0][k];
        const double far = node.high[k] - corners[0][k];
        bottom += normal[k] * (normal[k] >= 0 ? near : far);
        top += normal[k] * (normal[k] >= 0 ? far : near);
        reach = std::max({reach, -near, far});
      }
      return certain_distance(std::max(bottom - high, low - top), reach);
    }

    /// Proven distance of the slab from a triangle.
    double slab_distance(const Corners& t) const {
      double bottom = infinity, top = -infinity, reach = extent;
      for (const Point& corner : t) {
        const Point relative = corner - corners[0];
        const double height = normal.dot(relative);
        bottom = std::min(bottom, height);
        top = std::max(top, height);
        reach = std::max(reach, relative.lpNorm<Eigen::Infinity>());
      }
      return certain_distance(std::max(bottom - high, low - top), reach);
    }
  };

  /// Boxes farther apart than the nearest pair cannot hold a nearer one. The factor covers the rounding of the squares,
  /// the constant their underflow.
  bool too_far(double squared) const { return squared * (1 - 0x1p-48) >= std::max(nearest_ * nearest_, 1e-280); }

  void visit(std::int32_t t) {
    const Query query(outer_.mesh, t);
    const std::vector<BoxTree::Node>& nodes = inner_.tree.nodes;
    Stack stack;
    int top = 0;
    stack[top++] = 0;
    while (top > 0 && found_.clearance > 0) {
      const BoxTree::Node& node = nodes[stack[--top]];
      if (too_far(squared_gap(node, query.box)) || query.slab_distance(node) >= nearest_) continue;
      if (node.count > 0) {
        for (std::int32_t i = node.first; i < node.first + node.count; ++i) visit(query, inner_.tree.order[i]);
        continue;
      }
      const bool left_first =
          squared_gap(nodes[node.first], query.box) <= squared_gap(nodes[node.first + 1], query.box);
      stack[top++] = node.first + (left_first ? 1 : 0);
      stack[top++] = node.first + (left_first ? 0 : 1);
    }
  }

  void visit(const Query& query, std::int32_t inner) {
    if (found_.clearance == 0) return;
    const Corners t = corners(inner_.mesh, inner);
    const BoxTree::Node box = box_of(t);
    const double squared = squared_gap(box, query.box);
    if (too_far(squared)) return;
    const double rounding = clearance_rounding * common_extent(box, query.box);
    const double gap = squared > smallest_square ? std::sqrt(squared) * (1 - 0x1p-48) : 0;
    if (settle(std::max(gap, query.slab_distance(t)), nearest_, rounding)) return;
    const Separation s = separate(query.corners, t);
    if (settle(s.lower, std::min(nearest_, s.upper), rounding)) {
      // Not below the proven bound: what `nearest_` prunes must not be nearer than `clearance`.
      nearest_ = std::min(nearest_, std::max(s.lower, s.upper));
      return;
    }
    settle_exactly(query, inner, t);
  }

  /// Is the bound of this pair good enough, given that the distance of the surfaces is at most about `upper`?
  bool settle(double lower, double upper, double rounding) {
    if (lower == 0 || lower < upper * (1 - clearance_slack) - rounding) return false;
    found_.clearance = std::min(found_.clearance, lower);
    return true;
  }

  void settle_exactly(const Query& query, std::int32_t inner, const Corners& t) {
    const bool touching = touch(query.corners, t);
    const double distance = touching ? 0 : exact_distance(query.corners, t);
    found_.clearance = std::min(found_.clearance, distance);
    nearest_ = std::min(nearest_, distance);
    if (distance == 0) found_ = {touching, 0, query.triangle, inner};
  }

  const Surface& inner_;
  const Surface& outer_;
  Contact found_;
  double nearest_ = infinity;  ///< about the smallest distance so far; at least found_.clearance
};

}  // namespace

std::optional<TrianglePair> self_intersection(const Surface& surface) {
  for (std::int32_t t = 0; t < surface.mesh.triangles.rows(); ++t) {
    const std::int32_t other = overlapping(surface, t);
    if (other >= 0) return TrianglePair{t, other};
  }
  return std::nullopt;
}

Contact contact(const Surface& inner, const Surface& outer) { return ContactSearch(inner, outer).run(); }

int winding_number(const Surface& surface, const Point& p, int skip) {
  const BoxTree& tree = surface.tree;
  int winding = 0;
  Stack stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const BoxTree::Node& node = tree.nodes[stack[--top]];
    if (p[0] < node.low[0] || p[0] > node.high[0] || p[1] < node.low[1] || p[1] > node.high[1] || p[2] > node.high[2]) {
      continue;
    }
    if (node.count == 0) {
      stack[top++] = node.first + 1;
      stack[top++] = node.first;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const std::int32_t t = tree.order[i];
      if (surface.connectivity.component[t] != skip) winding += crossing_above(corners(surface.mesh, t), p);
    }
  }
  return winding;
}

std::vector<std::int32_t> first_triangles(const Surface& surface) {
  std::vector<std::int32_t> first(static_cast<std::size_t>(surface.connectivity.component_count), -1);
  for (std::int32_t t = 0; t < surface.mesh.triangles.rows(); ++t) {
    std::int32_t& entry = first[surface.connectivity.component[t]];
    if (entry < 0) entry = t;
  }
  return first;
}

}  // namespace encage::proof
