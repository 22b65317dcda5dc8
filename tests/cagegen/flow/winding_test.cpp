// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/winding.h"

#include "cagegen/flow/angle.h"
#include "tests/cagegen/geometry/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace encage::makers {
namespace {

using shapes::Random;

/// By another formula of the solid angle, and libm.
double brute_force(const TriangleMesh& mesh, const Point& p) {
  double sum = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) sum += solid_angle(p, shapes::corners(mesh, t));
  return sum / (4 * std::acos(-1.0));
}

TriangleMesh without_last_triangles(TriangleMesh mesh, std::int64_t count) {
  mesh.triangles.conservativeResize(mesh.triangles.rows() - count, 3);
  return mesh;
}

TEST(ArcTangent, AgreesWithLibm) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const double y = random(-1, 1) * (i % 3 ? 1 : 1e-9);
    const double x = random(-1, 1) * (i % 5 ? 1 : 1e-9);
    EXPECT_NEAR(arc_tangent(y, x), std::atan2(y, x), 1e-14) << y << " " << x;
  }
  EXPECT_EQ(arc_tangent(0, 0), 0);
  EXPECT_EQ(arc_tangent(0, 2), 0);
  EXPECT_NEAR(arc_tangent(0, -2), std::acos(-1.0), 1e-15);
  EXPECT_NEAR(arc_tangent(-3, 0), -std::acos(0.0), 1e-15);
}

TEST(WindingNumber, OfClosedSurfacesCountsThem) {
  const TriangleMesh ball = shapes::sphere(4);
  const TriangleMesh shell = shapes::joined(ball, shapes::flipped(shapes::scaled(ball, 0.5)));
  const TriangleMesh twice = shapes::joined(ball, ball);
  EXPECT_NEAR(WindingNumber(ball)(Point(0.3, 0.2, -0.4)), 1, 0.01);
  EXPECT_NEAR(WindingNumber(ball)(Point(0.8, 0.9, 0.7)), 0, 0.01);
  EXPECT_NEAR(WindingNumber(shell)(Point(0, 0.7, 0)), 1, 0.01);
  EXPECT_NEAR(WindingNumber(shell)(Point(0.1, 0, 0)), 0, 0.01);
  EXPECT_NEAR(WindingNumber(twice)(Point(0.3, 0.2, -0.4)), 2, 0.02);
  EXPECT_NEAR(WindingNumber(shapes::flipped(ball))(Point(0.3, 0.2, -0.4)), -1, 0.01);
}

TEST(WindingNumber, OfHalfAnOctahedronIsAHalfAtItsCentre) {
  const TriangleMesh half = without_last_triangles(shapes::sphere(0), 4);
  EXPECT_NEAR(WindingNumber(half)(Point::Zero()), 0.5, 1e-12);
}

TEST(WindingNumber, IsZeroForNothingAndInTheTrianglesPlane) {
  EXPECT_EQ(WindingNumber(TriangleMesh())(Point(1, 2, 3)), 0);
  const TriangleMesh one = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  EXPECT_EQ(WindingNumber(one)(Point(0.2, 0.2, 0)), 0);
  EXPECT_EQ(WindingNumber(one)(Point(0, 0, 0)), 0);
  EXPECT_NEAR(WindingNumber(one)(Point(0.2, 0.2, -1e-9)), 0.5, 1e-6);
}

TEST(WindingNumber, AgreesWithDirectSumsOnOpenSelfIntersectingSoups) {
  Random random(2);
  const TriangleMesh open = without_last_triangles(shapes::sphere(4), 700);
  const TriangleMesh crossing = shapes::joined(shapes::torus(1, 0.4, 40, 20), shapes::sphere(3));
  TriangleMesh soup = shapes::joined(open, shapes::moved(open, Point(0.3, 0.1, 0)));
  for (int i = 0; i < 50; ++i) {
    const Corners t = shapes::awkward_triangle(random, 1);
    soup = shapes::with_triangle(soup, t[0], t[1], t[2]);
  }
  for (const TriangleMesh& mesh : {open, crossing, soup}) {
    const WindingNumber winding(mesh);
    int decided = 0;
    for (int i = 0; i < 1000; ++i) {
      const Point p = random.point(i % 4 ? 1.5 : 20);
      const double expected = brute_force(mesh, p);
      EXPECT_NEAR(winding(p), expected, 0.02);
      if (std::abs(expected - 0.5) < 0.02) continue;
      ++decided;
      EXPECT_EQ(winding(p) > 0.5, expected > 0.5);
    }
    EXPECT_GT(decided, 900);
  }
}

}  // namespace
}  // namespace encage::makers
