// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/convex_distance.h"

#include "src/limits.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// Differences of points of the hull and corners, whose own hull is searched for the point nearest to the origin.
struct Simplex {
  std::array<Vector, 4> points = {Vector::Zero(), Vector::Zero(), Vector::Zero(), Vector::Zero()};
  int count = 0;

  void keep(std::initializer_list<int> which) {
    std::array<Vector, 4> kept = points;
    int n = 0;
    for (const int i : which) kept[static_cast<std::size_t>(n++)] = points[static_cast<std::size_t>(i)];
    points = kept;
    count = n;
  }
};

Vector nearest_on_segment(Simplex& s) {
  Vector a = s.points[0];
  const Vector u = s.points[1] - a;
  const double length = u.squaredNorm(), along = -a.dot(u);
  if (!(along > 0)) {
    s.keep({0});
    return a;
  }
  if (along >= length) {
    Vector b = s.points[1];
    s.keep({1});
    return b;
  }
  return a + along / length * u;
}

/// Ericson 2005, section 5.1.5.
Vector nearest_on_triangle(Simplex& s) {
  const Vector a = s.points[0], b = s.points[1], c = s.points[2];
  const Vector ab = b - a, ac = c - a;
  const double d1 = -ab.dot(a), d2 = -ac.dot(a), d3 = -ab.dot(b), d4 = -ac.dot(b), d5 = -ab.dot(c), d6 = -ac.dot(c);
  const double of_c = d1 * d4 - d3 * d2, of_b = d5 * d2 - d1 * d6, of_a = d3 * d6 - d5 * d4;
  const double sum = of_a + of_b + of_c;
  if (of_a > 0 && of_b > 0 && of_c > 0) return a + (of_b * ab + of_c * ac) / sum;
  // Outside, or degenerate: the nearest of the edges.
  double least = infinity;
  Vector best = a;
  Simplex chosen = s;
  for (const auto& [i, j] : {std::array{0, 1}, std::array{1, 2}, std::array{2, 0}}) {
    Simplex edge = s;
    edge.keep({i, j});
    const Vector p = nearest_on_segment(edge);
    if (p.squaredNorm() >= least) continue;
    least = p.squaredNorm();
    best = p;
    chosen = edge;
  }
  s = chosen;
  return best;
}

Vector nearest_on_tetrahedron(Simplex& s) {
  constexpr std::array<std::array<int, 4>, 4> faces = {{{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}}};
  bool outside = false;
  double least = infinity;
  Vector best = Vector::Zero();
  Simplex chosen = s;
  for (const auto& [i, j, k, opposite] : faces) {
    const auto at = [&](int n) -> const Vector& { return s.points[static_cast<std::size_t>(n)]; };
    const Vector n = (at(j) - at(i)).cross(at(k) - at(i));
    const double origin = -n.dot(at(i)), inner = n.dot(at(opposite) - at(i));
    if (origin * inner > 0) continue;
    outside = true;
    Simplex face = s;
    face.keep({i, j, k});
    const Vector p = nearest_on_triangle(face);
    if (p.squaredNorm() >= least) continue;
    least = p.squaredNorm();
    best = p;
    chosen = face;
  }
  if (outside) s = chosen;
  return best;
}

Vector nearest_to_origin(Simplex& s) {
  switch (s.count) {
    case 1: return s.points[0];
    case 2: return nearest_on_segment(s);
    case 3: return nearest_on_triangle(s);
    default: return nearest_on_tetrahedron(s);
  }
}

}  // namespace

bool hull_apart(std::span<const Vector> points, const TriangleD& triangle, double distance, Vector& axis) noexcept {
  constexpr int most_steps = 48;
  Simplex simplex;
  const Vector middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
  if (!(axis.squaredNorm() > smallest_square)) axis = points.front() - middle;
  for (int step = 0; step < most_steps; ++step) {
    // The axis leads from the triangle to the hull.
    std::size_t lowest = 0;
    double low = infinity, high = -infinity;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double height = axis.dot(points[i]);
      if (height < low) low = height, lowest = i;
    }
    std::size_t highest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double height = axis.dot(triangle[k]);
      if (height > high) high = height, highest = k;
    }
    const double length = axis.norm();
    if (length * length > smallest_square && low - high > length * distance) return true;
    const Vector support = points[lowest] - triangle[highest];
    // No nearer points than those at hand, which the axis is the line between.
    if (simplex.count > 0) {
      if (!(axis.dot(axis) - axis.dot(support) > 1e-15 * axis.dot(axis))) return false;
      for (int i = 0; i < simplex.count; ++i) {
        if (simplex.points[static_cast<std::size_t>(i)] == support) return false;
      }
    }
    simplex.points[static_cast<std::size_t>(simplex.count++)] = support;
    const Vector nearest = nearest_to_origin(simplex);
    if (simplex.count == 4 || !(nearest.squaredNorm() > smallest_square)) return false;
    if (step > 0 && !(nearest.norm() > distance)) return false;
    axis = nearest;
  }
  return false;
}

}  // namespace encage
