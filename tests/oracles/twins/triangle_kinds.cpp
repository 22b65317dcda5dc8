// SPDX-License-Identifier: GPL-3.0-or-later
// The tests of two triangles, at rest and moving.
#include "oracles/exact_pair.h"
#include "oracles/exact_sweep.h"
#include "oracles/lanes.h"
#include "oracles/sampled.h"
#include "oracles/twins/delicate.h"
#include "oracles/twins/pair_kind.h"
#include "oracles/twins/triangle_truth.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace encage::twins {

using test::Real;
using test::RealTriangle;
using test::TwinRandom;
using Vector = Eigen::Vector3d;

namespace {

double largest_norm(const TriangleD& t) { return std::max({t[0].norm(), t[1].norm(), t[2].norm()}); }

/// The largest amount that callers add for the rounding of the test.
double required(double margin, double norms) {
  constexpr double eps = std::numeric_limits<double>::epsilon();
  return margin * (1 + 64 * eps) + 4 * eps * norms;
}

RealTriangle real(const TriangleD& t) { return {t[0].cast<Real>(), t[1].cast<Real>(), t[2].cast<Real>()}; }

RealTriangle real(const MovingTriangle& m, Real t) {
  RealTriangle result;
  for (int k = 0; k < 3; ++k) result[k] = (1 - t) * m.start[k].cast<Real>() + t * m.end[k].cast<Real>();
  return result;
}

std::string text(const TriangleD& t) {
  std::ostringstream out;
  out << std::hexfloat;
  for (const Vector& v : t) out << " (" << v.x() << ", " << v.y() << ", " << v.z() << ")";
  return out.str();
}

class TrianglePairs : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t) const override {
    const auto [a, b, setting] = random_triangle_pair(random);
    // The margin is random, or equals the distance of the triangles.
    double margin = 0;
    if (random.coin()) margin = std::pow(10.0, -random.uniform(0, 8)) * setting.scale;
    if (random.below(3) == 0) margin = nudged(random, static_cast<double>(test::triangle_distance(real(a), real(b))));

    const double distance = required(margin, largest_norm(a) + largest_norm(b));
    const bool by_lanes = test::lanes_apart({a, a}, {b, b}, 1, distance);
    Outcome outcome{.rejected = triangles_apart(a, b, distance), .sampled = true, .truth = Truth::apart};
    if (test::triangles_meet(a, b, margin)) {
      outcome.truth = margin > 0 && !test::triangles_meet(a, b, 0) ? Truth::within_margin : Truth::touching;
    }
    outcome.missed = (outcome.rejected || by_lanes) && outcome.truth != Truth::apart;
    if (outcome.missed) outcome.what = text(a) + " and" + text(b) + ", margin " + std::to_string(margin);
    outcome.far = outcome.truth == Truth::apart && !test::triangles_meet(a, b, margin + 1e-6 * setting.scale);
    return outcome;
  }
};

test::MovingMesh mesh_of(const MovingTriangle& m) {
  test::MovingMesh mesh{Vertices(3, 3), Vertices(3, 3), Triangles(1, 3)};
  for (int k = 0; k < 3; ++k) {
    mesh.start.row(k) = m.start[k].transpose();
    mesh.end.row(k) = m.end[k].transpose();
    mesh.triangles(0, k) = k;
  }
  return mesh;
}

class MovingTriangles : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t) const override {
    MovingTriangle a = moving(random), b = moving(random);
    if (random.below(4) != 0) meet(random, a, b);
    const Setting setting = Setting::any(random);
    for (TriangleD* t : {&a.start, &a.end, &b.start, &b.end}) setting.apply(*t);
    double margin = 0;
    if (random.below(4) == 0) margin = std::pow(10.0, -random.uniform(0, 8)) * setting.scale;
    if (random.below(6) == 0) margin = nudged(random, least_distance(a, b));

    const double norms =
        std::max(largest_norm(a.start), largest_norm(a.end)) + std::max(largest_norm(b.start), largest_norm(b.end));
    const double distance = required(margin, norms);
    const bool quick = test::lanes_apart(a, b, 2, distance);
    Outcome outcome{.rejected = moving_triangles_apart(a, b, distance), .sampled = true, .truth = Truth::apart};
    const test::MovingMesh mesh_a = mesh_of(a), mesh_b = mesh_of(b);
    if (exact_contact(mesh_a, mesh_b)) {
      outcome.truth = Truth::touching;
    } else if (margin > 0 && reach(mesh_a, mesh_b, margin)) {
      outcome.truth = Truth::within_margin;
    }
    outcome.missed = (outcome.rejected || quick) && outcome.truth != Truth::apart;
    if (outcome.missed) {
      outcome.what = text(a.start) + " to" + text(a.end) + " and" + text(b.start) + " to" + text(b.end) + ", margin " +
                     std::to_string(margin);
    }
    // Time is cut into pieces no shorter than 2^-8, and turning edges lose as much.
    outcome.far = outcome.truth == Truth::apart && !come_within(mesh_a, mesh_b, margin + 0.05 * setting.scale, 0x1p-9);
    return outcome;
  }

 private:
  /// Returns a nearly rigid motion, or one with any other end.
  static MovingTriangle moving(TwinRandom& random) {
    MovingTriangle m{random_triangle(random), {}};
    if (random.below(4) == 0) {
      m.end = random_triangle(random);
      return m;
    }
    const double turn = random.coin() ? 3 : 0.2, way = random.coin() ? 1 : 0.05;
    const Eigen::Matrix3d r = Eigen::AngleAxisd(random.uniform(-turn, turn), random.direction()).toRotationMatrix();
    const Vector by = random.point(way);
    for (int k = 0; k < 3; ++k) m.end[k] = r * m.start[k] + by;
    if (random.below(6) == 0) m.end = m.start;
    return m;
  }

  /// Makes some points of both triangles meet, or almost meet, at some time.
  static void meet(TwinRandom& random, const MovingTriangle& a, MovingTriangle& b) {
    const double t = std::array{0.0, 0.5, 1.0, random.uniform(0, 1)}[random.below(4)];
    const auto at = [t](const MovingTriangle& m) { return TriangleD{m.corner(0, t), m.corner(1, t), m.corner(2, t)}; };
    const TriangleD ta = at(a), tb = at(b);
    const Vector by = point_of(random, ta) - point_of(random, tb) + random_gap(random, ta, tb);
    for (int k = 0; k < 3; ++k) b.start[k] += by, b.end[k] += by;
  }

  static double least_distance(const MovingTriangle& a, const MovingTriangle& b) {
    return static_cast<double>(
        test::least_value([&](Real t) { return test::triangle_distance(real(a, t), real(b, t)); }));
  }
};

}  // namespace

std::unique_ptr<PairKind> triangle_pairs() { return std::make_unique<TrianglePairs>(); }
std::unique_ptr<PairKind> moving_triangles() { return std::make_unique<MovingTriangles>(); }

}  // namespace encage::twins
