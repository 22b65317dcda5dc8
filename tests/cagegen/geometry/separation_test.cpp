// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/separation.h"

#include "cagegen/certify/exact.h"
#include "cagegen/certify/separation.h"
#include "tests/cagegen/geometry/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

// The certificate's exact predicates, with which the makers share no code, are the reference.
namespace encage::makers {
namespace {

using shapes::grid_point;
using shapes::Random;

Corners grid_triangle(Random& random, int n) {
  Corners t;
  do t = {grid_point(random, n), grid_point(random, n), grid_point(random, n)};
  while (proof::degenerate(t));
  return t;
}

Corners shifted(Corners t, const Point& by) {
  for (Point& p : t) p += by;
  return t;
}

TEST(TrianglesSeparated, NeverWhereTrianglesTouch) {
  Random random(31);
  int touching = 0;
  int apart = 0;
  int proven = 0;
  for (int i = 0; i < 60000; ++i) {
    Corners s = shapes::awkward_triangle(random, 1);
    Corners t = shapes::awkward_triangle(random, i % 3 ? 1 : 0.2);
    if (i % 4 == 0) {
      s = grid_triangle(random, 3);
      t = {grid_point(random, 3), grid_point(random, 3), grid_point(random, 3)};
    }
    if (i % 7 == 0) t[random.integer(3)] = s[random.integer(3)];                // a shared corner
    if (i % 7 == 1) t[0] = s[0] + random(0, 1) * (s[1] - s[0]);                 // on an edge, about
    if (i % 7 == 2) t[0] = (s[0] + s[1] + s[2]) / 3 + 1e-16 * random.point(1);  // in the face, about
    if (i % 7 == 3) t = shifted(t, random.point(1));
    if (i % 7 == 4) t = {s[0], s[1], random.point(1)};  // a shared edge
    const Point far = i % 2 ? Point::Zero().eval() : Point(1000, -2000, 1500);
    s = shifted(s, far);
    t = shifted(t, far);
    if (proof::degenerate(s)) continue;
    if (proof::touch(s, t)) {
      ++touching;
      // Nothing but the clearance makes up for rounding.
      EXPECT_FALSE(separated(s, t, 1e-9)) << i;
      EXPECT_FALSE(separated(t, s, 1e-9)) << i;
      EXPECT_FALSE(separated(s, t, 1e-3)) << i;
    } else if (proof::separate(s, t).lower > 1e-6) {
      ++apart;
      proven += separated(s, t, 1e-9) && separated(t, s, 1e-9);
    }
  }
  EXPECT_GT(touching, 15000);
  EXPECT_GT(apart, 5000);
  EXPECT_EQ(proven, apart) << "of two convex sets one of these axes always separates";
}

TEST(TrianglesSeparated, ByMoreThanTheClearance) {
  Random random(32);
  int far = 0;
  int proven = 0;
  for (int i = 0; i < 40000; ++i) {
    const Corners s = shapes::awkward_triangle(random, 1);
    const Corners t = shifted(shapes::awkward_triangle(random, i % 2 ? 1 : 0.1), random.point(2));
    const proof::Separation distance = proof::separate(s, t);
    const double clearance = std::pow(10.0, random(-6, 0));
    const bool said = separated(s, t, clearance);
    if (said) {
      EXPECT_GT(distance.upper, clearance * (1 - 1e-9)) << i;
    }
    if (distance.lower < 2 * clearance) continue;
    ++far;
    proven += said;
  }
  EXPECT_GT(far, 10000);
  EXPECT_GT(proven, 0.9 * far);
}

TEST(TrianglesSeparated, DegenerateTriangles) {
  const Point o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_FALSE(separated({o, o, o}, {o, o, o}, 0));
  EXPECT_FALSE(separated({o, x, 0.5 * x}, {0.5 * x, 2 * x, x}, 0)) << "collinear, overlapping";
  EXPECT_FALSE(separated({o, x, x}, {0.5 * x, y, y}, 0));
  EXPECT_FALSE(separated({o, x, y}, {0.25 * (x + y), 0.25 * (x + y), 0.25 * (x + y)}, 0)) << "a point in the face";
  EXPECT_TRUE(separated({o, o, x}, {z, z, z + y}, 0.9));
  EXPECT_TRUE(separated({o, x, x}, {2 * x, 3 * x, 3 * x}, 0.9)) << "collinear, a gap between";
  EXPECT_FALSE(separated({o, x, x}, {2 * x, 3 * x, 3 * x}, 1.1));
  EXPECT_TRUE(separated({o, x, y}, {x + y, x + y, x + y}, 0.7)) << "in the plane, beside";
}

TEST(SeparatedAtCorner, NeverWhereMoreIsShared) {
  Random random(33);
  int overlapping = 0;
  int apart = 0;
  int proven = 0;
  for (int i = 0; i < 60000; ++i) {
    Corners s = grid_triangle(random, i % 2 ? 3 : 4);
    Corners t = grid_triangle(random, i % 2 ? 3 : 4);
    if (i % 3 == 0) s[2].z() = s[1].z() = t[1].z() = t[2].z() = s[0].z();  // all in one plane
    if (i % 3 == 1) {
      s = {random.point(1), random.point(1), random.point(1)};
      t = {random.point(1), random.point(1), random.point(1)};
      if (i % 5 == 0) t[1] = s[0] + random(0.2, 2) * (s[1] - s[0]);  // along an edge, about
    }
    t[0] = s[0];
    if (proof::degenerate(s) || proof::degenerate(t)) continue;
    const Point& v = s[0];
    const bool said = separated_at_corner(v, s[1], s[2], t[1], t[2]);
    EXPECT_EQ(said, separated_at_corner(v, t[1], t[2], s[1], s[2])) << i;
    EXPECT_EQ(said, separated_at_corner(v, s[2], s[1], t[1], t[2])) << i;
    if (proof::overlap_at_vertex(v, s[1], s[2], t[1], t[2])) {
      ++overlapping;
      EXPECT_FALSE(said) << i;
    } else {
      ++apart;
      proven += said;
    }
  }
  EXPECT_GT(overlapping, 5000);
  EXPECT_GT(apart, 15000);
  EXPECT_GT(proven, 0.85 * apart);
}

TEST(SeparatedAtCorner, OppositeTrianglesOfAGrid) {
  const Point o(0.5, 0.25, 0), a(1, 1, 0), b(1, 0, 0);
  EXPECT_TRUE(separated_at_corner(o, o + a, o + b, o - a, o - b));
  EXPECT_TRUE(separated_at_corner(o, o + a, o + b, o - a, o + Point(-1, 2, 0)));
  EXPECT_TRUE(separated_at_corner(o, o + a, o + b, o - a, o + Point(-1, -1, 1)));
  // On the same side of the line.
  EXPECT_FALSE(separated_at_corner(o, o + a, o + b, o - a, o + Point(2, 0.5, 0)));
}

TEST(SeparatedAtEdge, NeverWhereTheTrianglesFold) {
  Random random(34);
  int folded = 0;
  int proven = 0;
  int apart = 0;
  for (int i = 0; i < 60000; ++i) {
    Corners s = grid_triangle(random, 3);
    Point d = grid_point(random, 3);
    if (i % 3 == 0) s[2].z() = d.z() = s[1].z() = s[0].z();
    if (i % 3 == 1) {
      s = {random.point(1), random.point(1), random.point(1)};
      d = random.point(1);
    }
    if (proof::degenerate(s) || proof::degenerate({s[1], s[0], d})) continue;
    const bool said = separated_at_edge(s[0], s[1], s[2], d);
    EXPECT_EQ(said, separated_at_edge(s[1], s[0], d, s[2])) << i;
    if (proof::overlap_at_edge(s[0], s[1], s[2], d)) {
      ++folded;
      EXPECT_FALSE(said) << i;
    } else {
      ++apart;
      proven += said;
    }
  }
  EXPECT_GT(folded, 3000);
  EXPECT_GT(proven, 0.99 * apart);
}

TEST(TrianglesSeparated, FansOfOneVertexAreClear) {
  // Around a vertex, spread in a plane, raised to a cone, folded to a star.
  for (const double height : {0.0, 0.3, -3.0}) {
    for (const double dent : {1.0, 0.4}) {
      constexpr int n = 9;
      std::vector<Point> rim;
      for (int i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        const double radius = i % 2 == 0 ? 1 : dent;
        rim.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
      }
      for (int i = 0; i < n; ++i) {
        for (int j = i + 1; j < n; ++j) {
          const std::array<std::int32_t, 3> s{n, i, (i + 1) % n};
          const std::array<std::int32_t, 3> t{j, (j + 1) % n, n};
          EXPECT_TRUE(
              separated(s, {Point::Zero(), rim[s[1]], rim[s[2]]}, t, {rim[t[0]], rim[t[1]], Point::Zero()}, 0.1))
              << i << ' ' << j;
        }
      }
    }
  }
}

TEST(TrianglesSeparated, ByIndices) {
  const Corners s{Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)};
  const Corners above = shifted(s, {0, 0, 1});
  EXPECT_TRUE(separated({0, 1, 2}, s, {3, 4, 5}, above, 0.5));
  EXPECT_FALSE(separated({0, 1, 2}, s, {3, 4, 5}, above, 1.5));
  EXPECT_FALSE(separated({0, 1, 2}, s, {2, 1, 0}, {s[2], s[1], s[0]}, 0)) << "all corners shared";
  // One corner, at every index.
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      std::array<std::int32_t, 3> index{3, 4, 5};
      Corners t{s[i] + Point(0.1, 0, 1), s[i] + Point(0, 0.2, 1), s[i] + Point(-0.1, 0.1, 1)};
      t[j] = s[i];
      index[j] = i;
      EXPECT_TRUE(separated({0, 1, 2}, s, index, t, 0.5)) << i << j;
      for (int k = 0; k < 3; ++k) {
        if (k != j) t[k] = (s[0] + s[1] + s[2]) / 3 + Point(0.1 * k, 0, 0.5 - k);  // through the face
      }
      if (!proof::degenerate(t) &&
          proof::overlap_at_vertex(s[i], s[(i + 1) % 3], s[(i + 2) % 3], t[(j + 1) % 3], t[(j + 2) % 3])) {
        EXPECT_FALSE(separated({0, 1, 2}, s, index, t, 0.5)) << i << j;
      }
    }
  }
  // One edge, at every index: open, and folded back onto the triangle.
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const int a = (i + 1) % 3, b = (i + 2) % 3;
      std::array<std::int32_t, 3> index{};
      Corners t;
      index[j] = 3, index[(j + 1) % 3] = b, index[(j + 2) % 3] = a;
      t[(j + 1) % 3] = s[b], t[(j + 2) % 3] = s[a];
      t[j] = s[a] + s[b] - s[i];
      EXPECT_TRUE(separated({0, 1, 2}, s, index, t, 0.5)) << i << j;
      t[j] = (s[0] + s[1] + s[2]) / 3;
      EXPECT_FALSE(separated({0, 1, 2}, s, index, t, 0.5)) << i << j;
    }
  }
}

TEST(CommonDirection, OfNormals) {
  const Point x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_TRUE(common_direction(std::vector<Point>{x}));
  EXPECT_TRUE(common_direction(std::vector<Point>{x, y, z}));
  EXPECT_FALSE(common_direction(std::vector<Point>{x, -x})) << "a folded sheet";
  EXPECT_FALSE(common_direction(std::vector<Point>{x, y, z, -x}));
  // Normals in a half-space, most of them on one side of it.
  Random random(36);
  for (int i = 0; i < 500; ++i) {
    const Point axis = random.point(1).normalized();
    std::vector<Point> normals;
    for (int k = 0; k < 12; ++k) {
      Point n = random.point(1).normalized();
      if (n.dot(axis) < 0) n = -n;
      normals.push_back((n + 0.5 * axis).normalized());
    }
    EXPECT_TRUE(common_direction(normals));
    normals.push_back(-normals[0]);
    EXPECT_FALSE(common_direction(normals));
  }
}

TEST(SolidAngle, OfClosedMeshes) {
  Random random(35);
  const auto sum = [](const TriangleMesh& mesh, const Point& x) {
    double angle = 0;
    for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) angle += solid_angle(x, shapes::corners(mesh, t));
    return angle;
  };
  constexpr double full = 4 * std::numbers::pi;
  const TriangleMesh cube = shapes::cube(1);
  const TriangleMesh torus = shapes::torus(2, 0.5, 24, 12);
  for (int i = 0; i < 500; ++i) {
    const Point x = random.point(3);
    const double reach = x.cwiseAbs().maxCoeff();
    if (std::abs(reach - 1) > 1e-6) {
      EXPECT_NEAR(sum(cube, x), reach < 1 ? full : 0, 1e-9);
    }
    const double ring = std::hypot(std::hypot(x.x(), x.y()) - 2, x.z());
    if (ring > 0.5) {
      EXPECT_NEAR(sum(torus, x), 0, 1e-9);
    }
    if (ring < 0.45) {
      EXPECT_NEAR(sum(torus, x), full, 1e-9);
    }
  }
  EXPECT_NEAR(sum(shapes::flipped(cube), Point::Zero()), -full, 1e-9);
  EXPECT_NEAR(solid_angle(Point::Zero(), {Point(1, 0, 0), Point(0, 1, 0), Point(0, 0, 1)}), full / 8, 1e-12);
}

}  // namespace
}  // namespace encage::makers
