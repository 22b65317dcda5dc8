// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/point_triangle.h"

#include <algorithm>
#include <limits>

namespace encage::makers {

namespace {

// Below this (sine of an angle, about) the differences of products in closest_point() lose their meaning.
constexpr double thinnest_sine = 1e-4;

Feature edge(int k) { return static_cast<Feature>(static_cast<int>(Feature::edge0) + k); }
Feature corner(int k) { return static_cast<Feature>(static_cast<int>(Feature::corner0) + k); }

ClosestPoint at(const Point& p, const Point& q, Feature feature) { return {q, (p - q).squaredNorm(), feature}; }

ClosestPoint on_edge(const Point& p, const Corners& t, int k) {
  const Point& a = t[k];
  const Point ab = t[(k + 1) % 3] - a;
  const double along = ab.dot(p - a);
  const double length2 = ab.squaredNorm();
  if (!(along > 0)) return at(p, a, corner(k));
  if (along >= length2) return at(p, t[(k + 1) % 3], corner((k + 1) % 3));
  return at(p, a + along / length2 * ab, edge(k));
}

/// The best of the three edges and the foot on the plane, each found for itself.
ClosestPoint on_thin(const Point& p, const Corners& t) {
  ClosestPoint best = on_edge(p, t, 0);
  for (int k = 1; k < 3; ++k) {
    const ClosestPoint other = on_edge(p, t, k);
    if (other.distance2 < best.distance2) best = other;
  }
  const Point n = (t[1] - t[0]).cross(t[2] - t[0]);
  const double n2 = n.squaredNorm();
  if (n2 == 0) return best;
  for (int k = 0; k < 3; ++k) {
    if (n.cross(t[(k + 1) % 3] - t[k]).dot(p - t[k]) < 0) return best;
  }
  const ClosestPoint foot = at(p, p - n.dot(p - t[0]) / n2 * n, Feature::face);
  return foot.distance2 < best.distance2 ? foot : best;
}

}  // namespace

bool is_thin(const Corners& t) {
  const Point u = t[1] - t[0];
  const Point v = t[2] - t[0];
  const double longest2 = std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()});
  return !(u.cross(v).norm() > thinnest_sine * longest2);
}

ClosestPoint closest_point(const Point& p, const Corners& t, bool thin) {
  if (thin) return on_thin(p, t);
  // By Voronoi regions (Ericson, Real-Time Collision Detection, section 5.1.5).
  const Point ab = t[1] - t[0];
  const Point ac = t[2] - t[0];
  const Point ap = p - t[0];
  const double b1 = ab.dot(ap);
  const double c1 = ac.dot(ap);
  if (b1 <= 0 && c1 <= 0) return at(p, t[0], Feature::corner0);
  const Point bp = p - t[1];
  const double b2 = ab.dot(bp);
  const double c2 = ac.dot(bp);
  if (b2 >= 0 && c2 <= b2) return at(p, t[1], Feature::corner1);
  const Point cp = p - t[2];
  const double b3 = ab.dot(cp);
  const double c3 = ac.dot(cp);
  if (c3 >= 0 && b3 <= c3) return at(p, t[2], Feature::corner2);
  const double over_c = b1 * c2 - b2 * c1;
  if (over_c <= 0 && b1 >= 0 && b2 <= 0) return at(p, t[0] + b1 / (b1 - b2) * ab, Feature::edge0);
  const double over_b = b3 * c1 - b1 * c3;
  if (over_b <= 0 && c1 >= 0 && c3 <= 0) return at(p, t[0] + c1 / (c1 - c3) * ac, Feature::edge2);
  const double over_a = b2 * c3 - b3 * c2;
  const double to_c = c2 - b2;
  const double to_b = b3 - c3;
  if (over_a <= 0 && to_c >= 0 && to_b >= 0) {
    return at(p, t[1] + to_c / (to_c + to_b) * (t[2] - t[1]), Feature::edge1);
  }
  const double sum = over_a + over_b + over_c;
  return at(p, t[0] + over_b / sum * ab + over_c / sum * ac, Feature::face);
}

}  // namespace encage::makers
