// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/twins/triangle_truth.h"

#include "oracles/sampled.h"

namespace encage::twins {

using test::MovingMesh;
using test::Real;
using test::RealTriangle;

namespace {

double speed(const MovingMesh& mesh) { return (mesh.end - mesh.start).rowwise().norm().maxCoeff(); }

RealTriangle at_time(const MovingMesh& one, Real t) {
  RealTriangle triangle;
  for (int k = 0; k < 3; ++k) {
    triangle[k] = (1 - t) * one.start.row(k).transpose().cast<Real>() + t * one.end.row(k).transpose().cast<Real>();
  }
  return triangle;
}

}  // namespace

MovingMesh one_triangle(const MovingMesh& mesh, std::int64_t triangle) {
  MovingMesh one{Vertices(3, 3), Vertices(3, 3), Triangles(1, 3)};
  for (int k = 0; k < 3; ++k) {
    one.start.row(k) = mesh.start.row(mesh.triangles(triangle, k));
    one.end.row(k) = mesh.end.row(mesh.triangles(triangle, k));
    one.triangles(0, k) = k;
  }
  return one;
}

bool reach(const MovingMesh& a, const MovingMesh& b, double distance) {
  constexpr double coarse = 0x1p-11, fine = 0x1p-14;
  if (!come_within(a, b, distance, coarse)) return false;
  const double certain = distance - 2 * fine * (speed(a) + speed(b));
  if (certain > 0 && come_within(a, b, certain, fine)) return true;
  if (a.triangles.rows() * b.triangles.rows() > 64 * 64) return false;
  for (const auto& [i, j] : close_triangles(a, b, distance)) {
    const MovingMesh p = one_triangle(a, i), q = one_triangle(b, j);
    if (!come_within(p, q, distance, fine)) continue;
    const auto at = [&](Real t) { return test::triangle_distance(at_time(p, t), at_time(q, t)); };
    if (test::least_value(at) <= distance) return true;
  }
  return false;
}

}  // namespace encage::twins
