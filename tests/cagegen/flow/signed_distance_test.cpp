// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/signed_distance.h"

#include "cagegen/geometry/closest.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace encage::makers {
namespace {

using shapes::Random;

double brute_force_distance(const TriangleMesh& mesh, const Point& p) {
  double best = 1e300;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    best = std::min(best, closest_points({p, p, p}, shapes::corners(mesh, t)).distance2);
  }
  return std::sqrt(best);
}

bool brute_force_inside(const TriangleMesh& mesh, const Point& p) {
  double sum = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) sum += solid_angle(p, shapes::corners(mesh, t));
  return sum > 2 * std::acos(-1.0);
}

/// On a vertex, an edge or a face, moved by up to `far`.
Point point_near(const TriangleMesh& mesh, Random& random, double far) {
  const Corners t = shapes::corners(mesh, random.integer(static_cast<int>(mesh.triangles.rows())));
  const double u = random(0, 1), w = random(0, 1 - u);
  switch (random.integer(3)) {
    case 0: return t[0] + random.point(far);
    case 1: return t[0] + u * (t[1] - t[0]) + random.point(far);
    default: return t[0] + u * (t[1] - t[0]) + w * (t[2] - t[0]) + random.point(far);
  }
}

/// Closed embedded meshes: smooth, sharp, thin, with a cavity, of two components, of slivers, far from the origin.
std::vector<TriangleMesh> embedded_meshes() {
  const TriangleMesh ball = shapes::sphere(3);
  TriangleMesh needle = shapes::tetrahedron(1);
  needle.vertices.col(2) *= 100;
  needle.vertices.col(1) *= 1e-3;
  return {ball,
          shapes::torus(1, 0.3, 24, 12),
          shapes::box(Point(-1, -1, 0), Point(1, 1, 1e-4)),
          shapes::joined(ball, shapes::flipped(shapes::scaled(ball, 0.7))),
          shapes::joined(ball, shapes::moved(ball, Point(2.01, 0, 0))),
          needle,
          shapes::moved(shapes::torus(1, 0.3, 24, 12), Point(1000, -2000, 500))};
}

TEST(SignedDistance, AgreesWithBruteForce) {
  Random random(3);
  for (const TriangleMesh& mesh : embedded_meshes()) {
    const SignedDistance pseudonormal(mesh);
    const SignedDistance winding(mesh, Sign::winding);
    const Eigen::AlignedBox3d box = bounds(mesh);
    const double size = box.diagonal().norm();
    const double rounding = 1e-13 * box.max().cwiseAbs().maxCoeff() + 1e-14 * size;
    for (int i = 0; i < 600; ++i) {
      const Point p = i % 3 == 0   ? Point(box.center() + random.point(size))
                      : i % 3 == 1 ? point_near(mesh, random, i % 2 ? 0.3 : 1e-3)
                                   : point_near(mesh, random, i % 2 ? 1e-6 : 1e-9);
      const int start = random.integer(static_cast<int>(mesh.triangles.rows()));
      const Nearest n = pseudonormal.nearest(p, start);
      const double expected = brute_force_distance(mesh, p);
      EXPECT_NEAR(std::abs(n.distance), expected, rounding);
      EXPECT_NEAR((p - n.point).norm(), expected, rounding);
      EXPECT_NEAR(n.direction.norm(), 1, 1e-9);
      if (expected < 100 * rounding) continue;
      EXPECT_EQ(n.distance < 0, brute_force_inside(mesh, p)) << i << " distance " << n.distance;
      EXPECT_EQ(winding.nearest(p).distance < 0, n.distance < 0) << i << " distance " << n.distance;
    }
  }
}

TEST(SignedDistance, AnswerDoesNotDependOnTheStart) {
  Random random(4);
  const TriangleMesh mesh = shapes::torus(1, 0.3, 24, 12);
  const SignedDistance surface(mesh);
  for (int i = 0; i < 500; ++i) {
    // Points on the axis of symmetry have many closest points.
    const Point p = i % 5 ? random.point(1.5) : Point(0, 0, random(-1, 1));
    const Nearest one = surface.nearest(p, random.integer(static_cast<int>(mesh.triangles.rows())));
    const Nearest other = surface.nearest(p, random.integer(static_cast<int>(mesh.triangles.rows())));
    EXPECT_EQ(one.triangle, other.triangle);
    EXPECT_EQ(one.point, other.point);
    EXPECT_EQ(one.direction, other.direction);
    EXPECT_EQ(one.distance, other.distance);
  }
}

TEST(SignedDistance, TriangleAndFeatureHoldTheClosestPoint) {
  Random random(5);
  const TriangleMesh mesh = shapes::sphere(2);
  const SignedDistance surface(mesh);
  std::array<int, 7> seen{};
  for (int i = 0; i < 2000; ++i) {
    const Nearest n = surface.nearest(random.point(2));
    const Corners t = shapes::corners(mesh, n.triangle);
    const int feature = static_cast<int>(n.feature);
    ++seen[feature];
    if (feature == 0) {
      const Point normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
      EXPECT_NEAR(normal.dot(n.point - t[0]), 0, 1e-12);
    } else if (feature < 4) {
      const Point a = t[feature - 1], b = t[feature % 3];
      EXPECT_NEAR((b - a).normalized().cross(n.point - a).norm(), 0, 1e-12);
    } else {
      EXPECT_EQ(n.point, t[feature - 4]);
    }
  }
  for (const int count : seen) EXPECT_GT(count, 10);
}

TEST(SignedDistance, DirectionIsTheGradient) {
  Random random(6);
  const SignedDistance surface(shapes::torus(1, 0.3, 48, 24));
  int smooth = 0;
  for (int i = 0; i < 1000; ++i) {
    const Point p = random.point(1.4);
    const Nearest n = surface.nearest(p);
    const double h = 1e-6;
    Point gradient;
    for (int k = 0; k < 3; ++k) {
      const Point e = h * Point::Unit(k);
      gradient[k] = (surface.nearest(p + e).distance - surface.nearest(p - e).distance) / (2 * h);
    }
    if (std::abs(gradient.norm() - 1) > 1e-4) continue;  // next to the medial axis
    ++smooth;
    EXPECT_NEAR((n.direction - gradient).norm(), 0, 1e-3);
  }
  EXPECT_GT(smooth, 950);
}

TEST(SignedDistance, NearTheSurfaceTheDirectionIsTheAngleWeightedNormal) {
  const SignedDistance cube(shapes::cube(1));
  const double near = 0.9 * cube.epsilon();
  EXPECT_DOUBLE_EQ(cube.epsilon(), 1e-5 * std::sqrt(12.0));
  // An unweighted sum would favour the faces with two triangles at the corner.
  for (int corner = 0; corner < 8; ++corner) {
    const Point v(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    for (const Point& p : {v, Point(v * (1 + near / 2))}) {
      EXPECT_NEAR((cube.nearest(p).direction - v.normalized()).norm(), 0, 1e-12);
    }
  }
  EXPECT_NEAR((cube.nearest(Point(1, 1, 0.2)).direction - Point(1, 1, 0).normalized()).norm(), 0, 1e-12);
  EXPECT_EQ(cube.nearest(Point(0.3, 0.1, 1 - near)).direction, Point(0, 0, 1));
  EXPECT_NEAR(cube.nearest(Point(0.3, 0.1, 1 - near)).distance, -near, 1e-15);
  // Farther away it is the direction of the closest point.
  const Point out = Point(1, 2, 3).normalized() * 2 * cube.epsilon();
  EXPECT_NEAR((cube.nearest(Point(1, 1, 1) + out).direction - out.normalized()).norm(), 0, 1e-9);
}

TEST(SignedDistance, TakesDegenerateTriangles) {
  Random random(7);
  TriangleMesh soup = shapes::sphere(2);
  for (int i = 0; i < 200; ++i) {
    const Corners t = shapes::awkward_triangle(random, 1);
    soup = shapes::with_triangle(soup, t[0], t[1], t[2]);
  }
  const SignedDistance surface(soup, Sign::winding);
  for (int i = 0; i < 1000; ++i) {
    const Point p = i % 2 ? random.point(2) : point_near(soup, random, 1e-6);
    EXPECT_NEAR(std::abs(surface.nearest(p).distance), brute_force_distance(soup, p), 1e-12) << i;
  }
}

TEST(SignedDistance, WindingNumberTellsTheSideOfOpenMeshes) {
  TriangleMesh open = shapes::sphere(4);
  open.triangles.conservativeResize(open.triangles.rows() - 60, 3);
  const SignedDistance surface(open, Sign::winding);
  EXPECT_LT(surface.nearest(Point(0.1, 0.2, 0.3)).distance, 0);
  EXPECT_GT(surface.nearest(Point(1, 1, 1)).distance, 0);
  EXPECT_LT(surface.nearest(Point(0.1, 0.2, 0.3)).direction.dot(Point(-1, -2, -3)), 0);
}

TEST(SignedDistance, SeveralThreadsMayAsk) {
  const TriangleMesh mesh = shapes::torus(1, 0.3, 60, 30);
  const SignedDistance surface(mesh);
  const auto sum = [&] {
    Random random(8);
    double total = 0;
    for (int i = 0; i < 3000; ++i) total += surface.nearest(random.point(1.5)).distance;
    return total;
  };
  const double expected = sum();
  std::vector<double> results(4);
  {
    std::vector<std::jthread> threads;
    for (double& result : results) threads.emplace_back([&] { result = sum(); });
  }
  for (const double result : results) EXPECT_EQ(result, expected);
}

TEST(SignedDistance, NeedsATriangle) { EXPECT_THROW(SignedDistance{TriangleMesh()}, Error); }

}  // namespace
}  // namespace encage::makers
