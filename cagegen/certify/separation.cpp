// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/separation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage::proof {
namespace {

/// The nearest pair of features so far, and directions that may separate there.
struct Nearest {
  double squared = std::numeric_limits<double>::infinity();
  Point between = Point::Zero();  ///< from the point of one triangle to that of the other
  Point normal = Point::Zero();   ///< of the face, or of both edges; more exact when they almost touch

  void offer(const Point& d, const Point& n) {
    const double s = d.squaredNorm();
    if (s >= squared) return;
    squared = s;
    between = d;
    normal = n;
  }
};

double clamp01(double x) { return std::clamp(x, 0.0, 1.0); }

/// Closest points of segments a + s u and b + t v, s and t in [0,1]: minimise over s unbounded, clamp, best t, clamp,
/// best s again.
void edge_edge(const Point& a, const Point& u, const Point& b, const Point& v, Nearest& nearest) {
  const Point w = b - a;
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double uv = u.dot(v);
  const double det = uu * vv - uv * uv;
  double s = det > 0 ? clamp01((w.dot(u) * vv - w.dot(v) * uv) / det) : 0;
  const double t = vv > 0 ? clamp01((s * uv - w.dot(v)) / vv) : 0;
  s = uu > 0 ? clamp01((t * uv + w.dot(u)) / uu) : 0;
  nearest.offer(w + t * v - s * u, u.cross(v));
}

/// p against the inside of the triangle; its edges are left to edge_edge.
void point_face(const Point& p, const Corners& t, Nearest& nearest) {
  const Point u = t[1] - t[0];
  const Point v = t[2] - t[0];
  const Point n = u.cross(v);
  const double nn = n.squaredNorm();
  if (!(nn > 0)) return;
  const Point w = p - t[0];
  const double b = w.cross(v).dot(n) / nn;
  const double c = u.cross(w).dot(n) / nn;
  if (b < 0 || c < 0 || b + c > 1) return;
  nearest.offer(b * u + c * v - w, n);
}

}  // namespace

double gap_along(const Point& direction, const Corners& a, const Corners& b) {
  const double length = direction.norm();
  if (!(length > 1e-140 && length < 1e140)) return 0;
  const Point d = direction / length;
  double low[2] = {0, std::numeric_limits<double>::infinity()};
  double high[2] = {0, -std::numeric_limits<double>::infinity()};
  double extent = 0;
  const Corners* const both[2] = {&a, &b};
  for (int side = 0; side < 2; ++side) {
    for (const Point& corner : *both[side]) {
      const Point relative = corner - a[0];
      const double height = d.dot(relative);
      low[side] = std::min(low[side], height);
      high[side] = std::max(high[side], height);
      extent = std::max(extent, relative.lpNorm<Eigen::Infinity>());
    }
  }
  return certain_distance(std::max(low[1] - high[0], low[0] - high[1]), extent);
}

Separation separate(const Corners& a, const Corners& b) {
  Nearest nearest;
  for (int i = 0; i < 3; ++i) {
    const Point u = a[(i + 1) % 3] - a[i];
    for (int j = 0; j < 3; ++j) edge_edge(a[i], u, b[j], b[(j + 1) % 3] - b[j], nearest);
    point_face(a[i], b, nearest);
    point_face(b[i], a, nearest);
  }
  Separation result;
  result.upper = std::sqrt(nearest.squared);
  result.lower = std::max(gap_along(nearest.between, a, b), gap_along(nearest.normal, a, b));
  return result;
}

}  // namespace encage::proof
