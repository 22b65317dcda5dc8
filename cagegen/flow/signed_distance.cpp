// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/signed_distance.h"

#include "cagegen/flow/angle.h"

#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace encage::makers {

namespace {

// Epsilon of eq. 6, in diagonals.
constexpr double epsilon_diagonals = 1e-5;

/// Accepts boxes that may come as near to a point as the best so far. Boxes are float: the point is widened to the
/// floats around it, and the bound covers the rounding of six operations.
class Ball {
 public:
  explicit Ball(const Point& p) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 3; ++axis) {
      const auto x = static_cast<float>(p[axis]);
      low_[axis] = Float4::broadcast(static_cast<double>(x) <= p[axis] ? x : std::nextafter(x, -infinity));
      high_[axis] = Float4::broadcast(static_cast<double>(x) >= p[axis] ? x : std::nextafter(x, infinity));
    }
  }

  void shrink(double distance2) {
    constexpr double slack = 1e-6;
    bound_ = Float4::broadcast(static_cast<float>(distance2 * (1 + slack)) + std::numeric_limits<float>::min());
  }

  Float4 distance2(const Float4 (&low)[3], const Float4 (&high)[3]) const {
    Float4 sum = Float4::broadcast(0);
    for (int axis = 0; axis < 3; ++axis) {
      const Float4 beside = max(max(low[axis] - high_[axis], low_[axis] - high[axis]), Float4::broadcast(0));
      sum = sum + beside * beside;
    }
    return sum;
  }

  Mask4 operator()(const Float4 (&low)[3], const Float4 (&high)[3]) const { return distance2(low, high) <= bound_; }

 private:
  Float4 low_[3];
  Float4 high_[3];
  Float4 bound_;
};

/// Angle at a corner; 0 if an edge vanishes.
double angle(const Corners& t, int k) {
  const Point u = t[(k + 1) % 3] - t[k];
  const Point v = t[(k + 2) % 3] - t[k];
  return arc_tangent(u.cross(v).norm(), u.dot(v));
}

}  // namespace

SignedDistance::SignedDistance(const TriangleMesh& mesh, Sign sign) : corners_(mesh.triangles) {
  if (mesh.triangles.rows() == 0) throw Error("signed distance: the mesh has no triangles");
  std::vector<Eigen::AlignedBox3d> boxes(static_cast<std::size_t>(mesh.triangles.rows()));
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (int k = 0; k < 3; ++k) boxes[t].extend(mesh.corner(static_cast<std::int64_t>(t), k));
  }
  tree_.build(boxes);
  slot_.resize(boxes.size());
  for (const std::int32_t t : tree_.renumber()) {
    slot_[t] = static_cast<std::int32_t>(triangles_.size());
    const Corners corner{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
    triangles_.push_back({corner, t, is_thin(corner)});
  }
  epsilon_ = epsilon_diagonals * bounds(mesh).diagonal().norm();
  compute_normals(mesh);
  if (sign == Sign::winding) winding_.emplace(mesh);
}

void SignedDistance::compute_normals(const TriangleMesh& mesh) {
  const std::size_t count = triangles_.size();
  face_normal_.assign(count, Point::Zero());
  edge_normal_.resize(count);
  vertex_normal_.assign(static_cast<std::size_t>(mesh.vertices.rows()), Point::Zero());
  struct Edge {
    std::int32_t low, high, triangle, side;
    bool operator<(const Edge& other) const {
      return std::tie(low, high, triangle, side) < std::tie(other.low, other.high, other.triangle, other.side);
    }
  };
  std::vector<Edge> edges;
  edges.reserve(3 * count);
  for (std::int32_t t = 0; t < static_cast<std::int32_t>(count); ++t) {
    const Corners& c = triangles_[slot_[t]].corner;
    face_normal_[t] = (c[1] - c[0]).cross(c[2] - c[0]).stableNormalized();
    for (int k = 0; k < 3; ++k) {
      vertex_normal_[corners_(t, k)] += angle(c, k) * face_normal_[t];
      const auto [low, high] = std::minmax(corners_(t, k), corners_(t, (k + 1) % 3));
      edges.push_back({low, high, t, k});
    }
  }
  for (Point& n : vertex_normal_) n = n.stableNormalized();
  std::sort(edges.begin(), edges.end());
  for (std::size_t first = 0, last = 0; first < edges.size(); first = last) {
    Point sum = Point::Zero();
    for (; last < edges.size() && edges[last].low == edges[first].low && edges[last].high == edges[first].high;
         ++last) {
      sum += face_normal_[edges[last].triangle];
    }
    sum = sum.stableNormalized();
    for (std::size_t e = first; e < last; ++e) edge_normal_[edges[e].triangle][edges[e].side] = sum;
  }
}

Point SignedDistance::normal(std::int32_t triangle, Feature feature) const {
  if (feature == Feature::face) return face_normal_[triangle];
  if (feature < Feature::corner0) {
    return edge_normal_[triangle][static_cast<int>(feature) - static_cast<int>(Feature::edge0)];
  }
  return vertex_normal_[corners_(triangle, static_cast<int>(feature) - static_cast<int>(Feature::corner0))];
}

Nearest SignedDistance::nearest(const Point& p, std::int32_t start) const {
  const Triangle* best = &triangles_[slot_[start]];
  ClosestPoint closest = closest_point(p, best->corner, best->thin);
  Ball ball(p);
  ball.shrink(closest.distance2);
  const auto nearness = [&](const Float4(&low)[3], const Float4(&high)[3]) {
    return Float4::broadcast(0) - ball.distance2(low, high);
  };
  tree_.traverse_ranked(ball, nearness, [&](std::int32_t slot) {
    const Triangle& triangle = triangles_[slot];
    const ClosestPoint found = closest_point(p, triangle.corner, triangle.thin);
    if (found.distance2 > closest.distance2) return;
    if (found.distance2 == closest.distance2 && triangle.index >= best->index) return;
    best = &triangle;
    closest = found;
    ball.shrink(closest.distance2);
  });
  const double distance = std::sqrt(closest.distance2);
  const Point away = p - closest.point;
  const Point n = normal(best->index, closest.feature);
  const bool inside = winding_ ? (*winding_)(p) > 0.5 : away.dot(n) < 0;
  Nearest result;
  result.point = closest.point;
  result.distance = inside ? -distance : distance;
  result.direction = distance > epsilon_ ? Point(away / result.distance) : n;
  result.triangle = best->index;
  result.feature = closest.feature;
  return result;
}

}  // namespace encage::makers
