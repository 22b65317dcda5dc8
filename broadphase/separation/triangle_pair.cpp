// SPDX-License-Identifier: Apache-2.0
#include "broadphase/separation/triangle_pair.h"

#include "src/limits.h"
#include "src/mesh/segments.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// True if b lies beyond a along n by more than `required`.
bool beyond(const Vector& n, const TriangleD& a, const TriangleD& b, double required) {
  const double a0 = n.dot(a[0]), a1 = n.dot(a[1]), a2 = n.dot(a[2]);
  const double b0 = n.dot(b[0]), b1 = n.dot(b[1]), b2 = n.dot(b[2]);
  return std::min({b0, b1, b2}) - std::max({a0, a1, a2}) > required;
}

/// Returns |n| distance, or infinity where underflow could have occurred in the norm or the projections.
double required_on(const Vector& n, double distance) {
  const double squared = n.squaredNorm();
  const double required = std::sqrt(squared) * distance;
  return squared > smallest_square && required > smallest_product ? required : std::numeric_limits<double>::infinity();
}

bool axis_separates(const Vector& n, const TriangleD& a, const TriangleD& b, double distance) {
  const double required = required_on(n, distance);
  return beyond(n, a, b, required) || beyond(n, b, a, required);
}

/// Two motions whose ends one axis has to separate, both in the same sense.
struct Piece {
  const MovingTriangle& a;
  const MovingTriangle& b;
  double distance;

  bool separated_by(const Vector& n) const {
    const double required = required_on(n, distance);
    return (beyond(n, a.start, b.start, required) && beyond(n, a.end, b.end, required)) ||
           (beyond(n, b.start, a.start, required) && beyond(n, b.end, a.end, required));
  }
};

TriangleD middle(const MovingTriangle& t) { return {t.corner(0, 0.5), t.corner(1, 0.5), t.corner(2, 0.5)}; }

/// Vector from a closest point of segment p0 p1 to one of segment q0 q1, up to rounding.
Vector closest_difference(const Vector& p0, const Vector& p1, const Vector& q0, const Vector& q1) {
  const Vector u = p1 - p0, v = q1 - q0;
  const auto [s, t] = closest_parameters(u, v, p0 - q0);
  return (q0 + t * v) - (p0 + s * u);
}

/// Calls separates(axis) for the axes that suffice for triangles at rest, until one separates.
template <class Separates>
bool any_axis(const TriangleD& a, const TriangleD& b, Separates&& separates) {
  const std::array<Vector, 3> ea = {a[1] - a[0], a[2] - a[1], a[0] - a[2]};
  const std::array<Vector, 3> eb = {b[1] - b[0], b[2] - b[1], b[0] - b[2]};
  if (separates(ea[0].cross(ea[1])) || separates(eb[0].cross(eb[1]))) return true;
  for (const Vector& u : ea) {
    for (const Vector& v : eb) {
      if (separates(u.cross(v))) return true;
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
  return separates(direction);
}

constexpr int longest_bisection = 8;  // halvings of a motion

bool apart_in(const MovingTriangle& a, const MovingTriangle& b, double distance, int depth, int& pieces) {
  ++pieces;
  const Piece piece{a, b, distance};
  const TriangleD middle_a = middle(a), middle_b = middle(b);
  const auto separates = [&](const Vector& n) { return piece.separated_by(n); };
  if (separates(middle_b[0] + middle_b[1] + middle_b[2] - (middle_a[0] + middle_a[1] + middle_a[2]))) return true;
  if (any_axis(middle_a, middle_b, separates)) return true;
  // Triangles that are too near in the middle cannot be separated on shorter intervals either.
  if (depth == longest_bisection || !triangles_apart(middle_a, middle_b, distance)) return false;
  return apart_in({a.start, middle_a}, {b.start, middle_b}, distance, depth + 1, pieces) &&
         apart_in({middle_a, a.end}, {middle_b, b.end}, distance, depth + 1, pieces);
}

}  // namespace

bool triangles_apart(const TriangleD& a, const TriangleD& b, double distance) noexcept {
  return any_axis(a, b, [&](const Vector& n) { return axis_separates(n, a, b, distance); });
}

bool moving_triangles_apart(const MovingTriangle& a, const MovingTriangle& b, double distance) noexcept {
  int pieces = 0;
  return moving_triangles_apart(a, b, distance, pieces);
}

bool moving_triangles_apart(const MovingTriangle& a, const MovingTriangle& b, double distance, int& pieces) noexcept {
  return apart_in(a, b, distance, 0, pieces);
}

}  // namespace encage
