// SPDX-License-Identifier: Apache-2.0
#include "broadphase/triangle_pair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

bool axis_separates(const Vector& n, const TriangleD& a, const TriangleD& b, double distance) {
  // Below these, underflow could have entered the norm or the projections.
  const double squared = n.squaredNorm();
  if (!(squared > 1e-280)) return false;
  const double required = std::sqrt(squared) * distance;
  if (!(required > 1e-290)) return false;
  const double a0 = n.dot(a[0]), a1 = n.dot(a[1]), a2 = n.dot(a[2]);
  const double b0 = n.dot(b[0]), b1 = n.dot(b[1]), b2 = n.dot(b[2]);
  return std::min({b0, b1, b2}) - std::max({a0, a1, a2}) > required ||
         std::min({a0, a1, a2}) - std::max({b0, b1, b2}) > required;
}

/// From a closest point of segment p0 p1 to one of segment q0 q1, up to rounding.
Vector closest_difference(const Vector& p0, const Vector& p1, const Vector& q0, const Vector& q1) {
  const Vector u = p1 - p0, v = q1 - q0, w = p0 - q0;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), uw = u.dot(w), vw = v.dot(w);
  const double determinant = uu * vv - uv * uv;
  const auto ratio = [](double numerator, double denominator) {
    return denominator > 0 ? std::clamp(numerator / denominator, 0.0, 1.0) : 0.0;
  };
  // Closest points of the lines, clamped to the first segment, then to the
  // second; the first follows the second once more.
  double s = ratio(uv * vw - vv * uw, determinant);
  const double t = ratio(uv * s + vw, vv);
  s = ratio(uv * t - uw, uu);
  return (q0 + t * v) - (p0 + s * u);
}

}  // namespace

bool triangles_apart(const TriangleD& a, const TriangleD& b, double distance) noexcept {
  const std::array<Vector, 3> ea = {a[1] - a[0], a[2] - a[1], a[0] - a[2]};
  const std::array<Vector, 3> eb = {b[1] - b[0], b[2] - b[1], b[0] - b[2]};
  if (axis_separates(ea[0].cross(ea[1]), a, b, distance)) return true;
  if (axis_separates(eb[0].cross(eb[1]), a, b, distance)) return true;
  for (const Vector& u : ea) {
    for (const Vector& v : eb) {
      if (axis_separates(u.cross(v), a, b, distance)) return true;
    }
  }
  Vector direction = Vector::Zero();
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vector d = closest_difference(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]);
      const double squared = d.squaredNorm();
      if (squared < smallest) {
        smallest = squared;
        direction = d;
      }
    }
  }
  return axis_separates(direction, a, b, distance);
}

}  // namespace encage
