// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/nesting.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace encage::proof {
namespace {

double brute_force_distance(const TriangleMesh& a, const TriangleMesh& b) {
  double best = std::numeric_limits<double>::infinity();
  for (std::int32_t i = 0; i < a.triangles.rows(); ++i) {
    for (std::int32_t j = 0; j < b.triangles.rows(); ++j) {
      best = std::min(best, exact_distance(corners(a, i), corners(b, j)));
    }
  }
  return best;
}

/// `extent`: of the meshes, which bounds that of every pair.
void expect_clearance(double got, double distance, double extent) {
  EXPECT_GT(got, 0);
  EXPECT_LE(got, distance * (1 + 4e-15));
  EXPECT_GE(got, distance * (1 - clearance_slack) - clearance_rounding * extent);
}

TEST(Contact, MatchesBruteForce) {
  shapes::Random random(3);
  for (int round = 0; round < 30; ++round) {
    TriangleMesh inner = shapes::sphere(1);
    TriangleMesh outer = shapes::sphere(1);
    // Some triangles of the inner mesh are segments or points.
    for (int i = 0; i < 3; ++i) {
      const int t = random.integer(static_cast<int>(inner.triangles.rows()));
      inner.triangles(t, 1) = inner.triangles(t, random.integer(3));
    }
    for (Eigen::Index v = 0; v < inner.vertices.rows(); ++v) inner.vertices.row(v) *= random(0.3, 0.6);
    for (Eigen::Index v = 0; v < outer.vertices.rows(); ++v) outer.vertices.row(v) *= random(1.0, 1.7);
    const Eigen::Vector3d by = random.point(round % 3 == 0 ? 1e5 : 1);
    inner = shapes::moved(inner, by);
    outer = shapes::moved(outer, by);
    const Contact found = contact(Surface(inner), Surface(outer));
    ASSERT_FALSE(found.touch);
    expect_clearance(found.clearance, brute_force_distance(inner, outer), 4);
  }
}

TEST(Contact, FarBelowTheRoundingOfTheCoordinates) {
  // Opposite slanted faces, 2^-50 apart in coordinates of size 1.
  const TriangleMesh inner = shapes::tetrahedron(1);
  for (const double gap : {0x1p-30, 0x1p-45, 0x1p-50, 0x1p-52}) {
    const TriangleMesh outer = shapes::mesh({{1 + gap, 0, 0}, {0, 1 + gap, 0}, {0, 0, 1 + gap}}, {{0, 1, 2}});
    const Contact found = contact(Surface(inner), Surface(outer));
    ASSERT_FALSE(found.touch);
    expect_clearance(found.clearance, gap / std::sqrt(3.0), 1 + gap);
  }
}

TEST(Contact, BeyondTheRangeOfDouble) {
  TriangleMesh inner = shapes::tetrahedron(1);
  TriangleMesh outer = shapes::mesh({{0, 0, -1e-200}, {1, 0, -1e-200}, {0, 1, -1e-200}}, {{0, 1, 2}});
  const Contact found = contact(Surface(inner), Surface(outer));
  EXPECT_FALSE(found.touch);
  EXPECT_EQ(found.clearance, 0);
  EXPECT_EQ(found.inner, 0);
}

TEST(Contact, NamesTheTouchingPair) {
  const TriangleMesh inner = shapes::with_triangle(shapes::cube(1), {0, 0, 0}, {0, 0, 2}, {0, 0, 3});
  const Contact found = contact(Surface(inner), Surface(shapes::cube(3)));
  EXPECT_TRUE(found.touch);
  EXPECT_EQ(found.inner, 12);
  EXPECT_TRUE(touch(corners(shapes::cube(3), found.outer), corners(inner, 12)));
}

TEST(SelfIntersection, NoneInSoundMeshes) {
  EXPECT_FALSE(self_intersection(Surface(shapes::sphere(3))));
  EXPECT_FALSE(self_intersection(Surface(shapes::torus(2, 0.5, 40, 17))));
  EXPECT_FALSE(self_intersection(Surface(shapes::cube(1))));
}

TEST(SelfIntersection, FoundHoweverTheTrianglesAreConnected) {
  const auto found = [](const TriangleMesh& m) { return self_intersection(Surface(m)).has_value(); };
  EXPECT_TRUE(found(shapes::joined(shapes::cube(1), shapes::cube(1, {1.5, 1.5, 1.5})))) << "crossing";
  EXPECT_TRUE(found(shapes::joined(shapes::cube(1), shapes::cube(1, {2, 0, 0})))) << "coplanar faces";
  EXPECT_TRUE(found(shapes::joined(shapes::cube(1), shapes::cube(1, {2, 2, 2})))) << "equal corners, not shared";
  TriangleMesh spun = shapes::torus(2, 2.5, 12, 12);
  EXPECT_TRUE(found(spun)) << "tube wider than the ring";
  TriangleMesh folded = shapes::sphere(2);
  folded.vertices.row(0) *= -0.5;  // pulled through the other side of its own fan's neighbours
  EXPECT_FALSE(found(folded)) << "still star-shaped around a point";
  folded.vertices.row(0) *= 3;
  EXPECT_TRUE(found(folded));
  TriangleMesh flap = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.5, 0}}, {{0, 1, 2}, {1, 0, 3}});
  EXPECT_TRUE(found(flap)) << "folded flat onto the neighbour";
}

TEST(WindingNumber, CountsWithSign) {
  const TriangleMesh shell = shapes::joined(shapes::sphere(2), shapes::flipped(shapes::scaled(shapes::sphere(2), 0.5)));
  const Surface surface(shell);
  EXPECT_EQ(winding_number(surface, {0.75, 0, 0}), 1);
  EXPECT_EQ(winding_number(surface, {0, 0, 0}), 0);
  EXPECT_EQ(winding_number(surface, {0, 0, 0}, 1), 1) << "without the cavity";
  EXPECT_EQ(winding_number(surface, {0, 0, -3}), 0);
  const TriangleMesh twice = shapes::joined(shapes::cube(1), shapes::cube(2));
  EXPECT_EQ(winding_number(Surface(twice), {0, 0, 0}), 2);
  EXPECT_EQ(winding_number(Surface(shapes::flipped(twice)), {0, 0, 0}), -2);
}

TEST(WindingNumber, OfATorusFromItsVerticesGrid) {
  // Points in the planes and lines of the vertices: every degenerate case of the vertical line.
  const TriangleMesh torus = shapes::torus(4, 1, 8, 8);
  const Surface surface(torus);
  for (int x = -12; x <= 12; ++x) {
    for (int y = -12; y <= 12; ++y) {
      const Eigen::Vector3d p(x * 0.5, y * 0.5, 0);
      const double from_ring = p.norm();
      // The polygonal tube lies between tubes of radius cos(pi/8)^2 < 0.86 about a ring between 3.69 and 4.
      if (from_ring > 3.5 && from_ring < 4.2) {
        EXPECT_EQ(winding_number(surface, p), 1) << p.transpose();
      } else if (from_ring < 2.7 || from_ring > 5.1) {
        EXPECT_EQ(winding_number(surface, p), 0) << p.transpose();
      }
    }
  }
}

}  // namespace
}  // namespace encage::proof
