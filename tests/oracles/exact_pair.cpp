// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/exact_pair.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Triangle_3.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

namespace encage::test {

using K = CGAL::Exact_predicates_exact_constructions_kernel;
using Point = K::Point_3;
using Triangle = std::array<Point, 3>;

struct ExactBody::Data {
  std::vector<Triangle> triangles;
  std::vector<CGAL::Bbox_3> boxes;
  std::vector<Point> component_points;
};

namespace {

Point exact(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

CGAL::Bbox_3 box(const Triangle& t) { return t[0].bbox() + t[1].bbox() + t[2].bbox(); }

bool boxes_farther(const CGAL::Bbox_3& a, const CGAL::Bbox_3& b, double distance) {
  // The factor covers the rounding of these sums.
  const double reach = distance * (1 + 1e-12);
  double squared = 0;
  for (int k = 0; k < 3; ++k) {
    const double slack = 1e-12 * (std::abs(a.max(k)) + std::abs(b.max(k)) + reach);
    const double gap = std::max({b.min(k) - a.max(k) - slack, a.min(k) - b.max(k) - slack, 0.0});
    if (gap > reach) return true;
    squared += gap * gap;
  }
  return std::sqrt(squared) > reach;
}

// CGAL requires triangles with an area; the distances below treat the others, since a degenerate triangle is the union
// of its edges.
bool intersect(const Triangle& a, const Triangle& b) {
  if (CGAL::collinear(a[0], a[1], a[2]) || CGAL::collinear(b[0], b[1], b[2])) return false;
  return CGAL::do_intersect(K::Triangle_3(a[0], a[1], a[2]), K::Triangle_3(b[0], b[1], b[2]));
}

K::FT squared_distance(const Point& p, const Point& q, const Point& r, const Point& s) {
  if (p == q && r == s) return CGAL::squared_distance(p, r);
  if (p == q) return CGAL::squared_distance(p, K::Segment_3(r, s));
  if (r == s) return CGAL::squared_distance(r, K::Segment_3(p, q));
  return CGAL::squared_distance(K::Segment_3(p, q), K::Segment_3(r, s));
}

bool vertex_within(const Triangle& a, const Triangle& b, const K::FT& squared) {
  if (CGAL::collinear(b[0], b[1], b[2])) return false;
  const K::Triangle_3 face(b[0], b[1], b[2]);
  return CGAL::squared_distance(a[0], face) <= squared || CGAL::squared_distance(a[1], face) <= squared ||
         CGAL::squared_distance(a[2], face) <= squared;
}

bool meet(const Triangle& a, const Triangle& b, double distance) {
  if (intersect(a, b)) return true;
  const bool degenerate = CGAL::collinear(a[0], a[1], a[2]) || CGAL::collinear(b[0], b[1], b[2]);
  if (distance == 0 && !degenerate) return false;
  const K::FT squared = K::FT(distance) * K::FT(distance);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (squared_distance(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]) <= squared) return true;
      // An edge may pass through the other triangle's face far from its edges.
      if (!CGAL::collinear(b[0], b[1], b[2]) && a[i] != a[(i + 1) % 3] &&
          CGAL::do_intersect(K::Segment_3(a[i], a[(i + 1) % 3]), K::Triangle_3(b[0], b[1], b[2]))) {
        return true;
      }
      if (!CGAL::collinear(a[0], a[1], a[2]) && b[j] != b[(j + 1) % 3] &&
          CGAL::do_intersect(K::Segment_3(b[j], b[(j + 1) % 3]), K::Triangle_3(a[0], a[1], a[2]))) {
        return true;
      }
    }
  }
  return vertex_within(a, b, squared) || vertex_within(b, a, squared);
}

// Counts the crossings of segment p q, with sign; no value if it meets an edge or a plane contains p or q.
bool count_crossings(const ExactBody::Data& body, const Point& p, const Point& q, int& sum) {
  sum = 0;
  for (const Triangle& t : body.triangles) {
    const CGAL::Orientation below = CGAL::orientation(t[0], t[1], t[2], p);
    const CGAL::Orientation above = CGAL::orientation(t[0], t[1], t[2], q);
    if (below == above && below != CGAL::COPLANAR) continue;
    const CGAL::Orientation s0 = CGAL::orientation(p, q, t[0], t[1]);
    const CGAL::Orientation s1 = CGAL::orientation(p, q, t[1], t[2]);
    const CGAL::Orientation s2 = CGAL::orientation(p, q, t[2], t[0]);
    const bool positive = s0 == CGAL::POSITIVE || s1 == CGAL::POSITIVE || s2 == CGAL::POSITIVE;
    const bool negative = s0 == CGAL::NEGATIVE || s1 == CGAL::NEGATIVE || s2 == CGAL::NEGATIVE;
    if (positive && negative) continue;
    if (s0 == CGAL::COPLANAR || s1 == CGAL::COPLANAR || s2 == CGAL::COPLANAR) return false;
    if (below == CGAL::COPLANAR || above == CGAL::COPLANAR) return false;
    sum += positive ? 1 : -1;
  }
  return true;
}

int winding(const ExactBody::Data& body, const Point& p) {
  CGAL::Bbox_3 all = p.bbox();
  for (const CGAL::Bbox_3& b : body.boxes) all += b;
  const double size = all.x_span() + all.y_span() + all.z_span();
  for (int attempt = 0; attempt < 50; ++attempt) {
    // The end is beyond the box, at another position in each attempt.
    const Point q(all.xmax() + size, all.ymin() + size * (0.137 + 0.0713 * attempt),
                  all.zmin() + size * (0.711 - 0.0457 * attempt));
    int sum = 0;
    if (count_crossings(body, p, q, sum)) return sum;
  }
  throw std::runtime_error("no ray without degeneracy");
}

bool in_range(const K::FT& t, const ExactRay& ray) {
  return (std::isinf(ray.low) || t >= K::FT(ray.low)) && (std::isinf(ray.high) || t <= K::FT(ray.high));
}

/// For a line o + t d and the segment a b, which may be a point.
bool ray_meets(const ExactRay& ray, const Point& o, const K::Vector_3& d, const Point& a, const Point& b) {
  const K::Vector_3 u = b - a, w = a - o, c = CGAL::cross_product(u, d);
  if (c != CGAL::NULL_VECTOR) {
    if (w * c != 0) return false;
    const K::FT s = -(CGAL::cross_product(w, d) * c) / c.squared_length();
    const K::FT t = -(CGAL::cross_product(w, u) * c) / c.squared_length();
    return s >= 0 && s <= 1 && in_range(t, ray);
  }
  if (CGAL::cross_product(w, d) != CGAL::NULL_VECTOR) return false;
  const K::FT ta = (w * d) / d.squared_length(), tb = ((b - o) * d) / d.squared_length();
  const K::FT low = std::min(ta, tb), high = std::max(ta, tb);
  return (std::isinf(ray.low) || high >= K::FT(ray.low)) && (std::isinf(ray.high) || low <= K::FT(ray.high));
}

bool ray_meets(const ExactRay& ray, const Triangle& t) {
  const Point o = exact(ray.origin);
  const K::Vector_3 d(ray.direction.x(), ray.direction.y(), ray.direction.z());
  const K::Vector_3 n = CGAL::cross_product(t[1] - t[0], t[2] - t[0]);
  const K::FT rate = n * d;
  if (rate != 0) {
    const K::FT at = (n * (t[0] - o)) / rate;
    if (!in_range(at, ray)) return false;
    const Point p = o + at * d;
    for (int k = 0; k < 3; ++k) {
      if (CGAL::cross_product(t[(k + 1) % 3] - t[k], p - t[k]) * n < 0) return false;
    }
    return true;
  }
  for (int k = 0; k < 3; ++k) {
    if (ray_meets(ray, o, d, t[k], t[(k + 1) % 3])) return true;
  }
  if (n == CGAL::NULL_VECTOR || std::isinf(ray.low) || n * (t[0] - o) != 0) return false;
  // In the plane, without an edge in its way: all of it is in the triangle, or nothing.
  const Point p = o + K::FT(ray.low) * d;
  for (int k = 0; k < 3; ++k) {
    if (CGAL::cross_product(t[(k + 1) % 3] - t[k], p - t[k]) * n < 0) return false;
  }
  return true;
}

}  // namespace

ExactBody::ExactBody(const Eigen::Vector3d& origin, const TriangleMesh& mesh, const Eigen::Isometry3d& pose,
                     double scale)
    : data_(std::make_unique<Data>()) {
  std::vector<Point> points;
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    std::array<K::FT, 3> x, y;
    for (int k = 0; k < 3; ++k) x[k] = K::FT(scale) * (K::FT(origin[k]) + K::FT(mesh.vertices(v, k)));
    for (int k = 0; k < 3; ++k) {
      y[k] = K::FT(pose(k, 3));
      for (int j = 0; j < 3; ++j) y[k] += K::FT(pose(k, j)) * x[j];
    }
    points.emplace_back(y[0], y[1], y[2]);
  }
  std::vector<std::int32_t> label;
  triangle_components(mesh, label);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const auto row = mesh.triangles.row(t);
    data_->triangles.push_back({points[row(0)], points[row(1)], points[row(2)]});
    data_->boxes.push_back(box(data_->triangles.back()));
    // This is another vertex than the one that the code under test uses.
    const std::size_t component = static_cast<std::size_t>(label[t]);
    if (component >= data_->component_points.size()) data_->component_points.resize(component + 1);
    data_->component_points[component] = points[row(2)];
  }
}

ExactBody::~ExactBody() = default;
ExactBody::ExactBody(ExactBody&&) noexcept = default;

bool surfaces_meet(const ExactBody& a, const ExactBody& b, double distance) {
  for (std::size_t i = 0; i < a.data().triangles.size(); ++i) {
    for (std::size_t j = 0; j < b.data().triangles.size(); ++j) {
      if (boxes_farther(a.data().boxes[i], b.data().boxes[j], distance)) continue;
      if (meet(a.data().triangles[i], b.data().triangles[j], distance)) return true;
    }
  }
  return false;
}

bool triangles_meet(const ExactBody& a, std::int64_t i, const ExactBody& b, std::int64_t j, double distance) {
  return !boxes_farther(a.data().boxes[i], b.data().boxes[j], distance) &&
         meet(a.data().triangles[i], b.data().triangles[j], distance);
}

bool ray_meets(const ExactBody& body, std::int64_t i, const ExactRay& ray) {
  return ray_meets(ray, body.data().triangles[static_cast<std::size_t>(i)]);
}

bool all_beyond(const ExactBody& body, const Eigen::Vector3d& n, double offset, double distance) {
  const K::Vector_3 normal(n.x(), n.y(), n.z());
  const K::FT squared = K::FT(distance) * K::FT(distance) * normal.squared_length();
  for (const Triangle& t : body.data().triangles) {
    for (const Point& p : t) {
      const K::FT height = normal * (p - CGAL::ORIGIN) - K::FT(offset);
      if (height <= 0 || height * height <= squared) return false;
    }
  }
  return true;
}

int winding_number(const ExactBody& body, const Eigen::Vector3d& point) { return winding(body.data(), exact(point)); }

bool holds_component(const ExactBody& host, const ExactBody& guest) {
  for (const Point& p : guest.data().component_points) {
    if (winding(host.data(), p) != 0) return true;
  }
  return false;
}

bool triangles_meet(const Corners& a, const Corners& b, double distance) {
  return meet({exact(a[0]), exact(a[1]), exact(a[2])}, {exact(b[0]), exact(b[1]), exact(b[2])}, distance);
}

}  // namespace encage::test
