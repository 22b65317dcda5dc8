// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/convex_hull.h"

#include "cagegen/certify/certify.h"
#include "cagegen/geometry/separation.h"
#include "tests/cagegen/geometry/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace encage::makers {
namespace {

using shapes::Random;

std::vector<Point> grid(int nx, int ny, int nz) {
  std::vector<Point> points;
  for (int i = 0; i < nx * ny * nz; ++i) points.emplace_back(i % nx, i / nx % ny, i / nx / ny);
  return points;
}

void shuffle(std::vector<Point>& points, Random& random) {
  for (std::size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[random.integer(static_cast<int>(i))]);
}

/// Closed, convex, and no point outside.
void expect_hull(const TriangleMesh& hull, const std::vector<Point>& points) {
  EXPECT_TRUE(certify_alone(hull).holds) << certify_alone(hull).reason;
  for (std::int64_t t = 0; t < hull.triangles.rows(); ++t) {
    const Corners c = shapes::corners(hull, t);
    const Point normal = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
    for (const Point& p : points) ASSERT_LE(normal.dot(p - c[0]), 1e-9);
  }
  for (std::int64_t v = 0; v < hull.vertices.rows(); ++v) {
    EXPECT_NE(std::find(points.begin(), points.end(), Point(hull.vertices.row(v).transpose())), points.end());
  }
}

TEST(ConvexHull, RandomPoints) {
  Random random(51);
  for (int i = 0; i < 50; ++i) {
    std::vector<Point> points;
    for (int k = 4 + random.integer(60); k > 0; --k) points.push_back(random.point(1));
    const auto hull = convex_hull(points);
    ASSERT_TRUE(hull);
    expect_hull(*hull, points);
    // Fans of triangles: V - E + F = 2.
    EXPECT_EQ(hull->triangles.rows(), 2 * hull->vertices.rows() - 4);
  }
}

TEST(ConvexHull, ABoxOfGridPointsHasEightCorners) {
  const std::vector<Point> points = grid(4, 3, 5);
  const auto hull = convex_hull(points);
  ASSERT_TRUE(hull);
  expect_hull(*hull, points);
  EXPECT_EQ(hull->vertices.rows(), 8);
  EXPECT_EQ(hull->triangles.rows(), 12);
  EXPECT_DOUBLE_EQ(signed_volume(*hull), 3 * 2 * 4);
}

TEST(ConvexHull, DependsOnTheSetOfPointsAlone) {
  Random random(52);
  for (int round = 0; round < 20; ++round) {
    // Many coplanar points: cut corners off a grid.
    std::vector<Point> points;
    const int cut = 3 + round % 9;
    for (const Point& p : grid(6, 6, 6)) {
      if (p.sum() >= cut && p.x() - p.y() + p.z() <= 15 - cut) points.push_back(p);
    }
    const auto first = convex_hull(points);
    ASSERT_TRUE(first);
    expect_hull(*first, points);
    for (int i = 0; i < 5; ++i) {
      // Other orders, duplicates, and other addresses.
      const auto heap = std::make_unique<std::vector<char>>(static_cast<std::size_t>(random.integer(100000)));
      points.push_back(points[random.integer(static_cast<int>(points.size()))]);
      shuffle(points, random);
      const auto again = convex_hull(points);
      ASSERT_TRUE(again);
      EXPECT_EQ(first->vertices, again->vertices);
      EXPECT_EQ(first->triangles, again->triangles);
    }
  }
}

TEST(ConvexHull, FlatInput) {
  EXPECT_FALSE(convex_hull({}));
  EXPECT_FALSE(convex_hull(grid(1, 1, 1)));
  EXPECT_FALSE(convex_hull(std::vector<Point>(9, Point(1, 2, 3))));
  EXPECT_FALSE(convex_hull(grid(2, 1, 1)));
  EXPECT_FALSE(convex_hull(grid(9, 1, 1)));
  EXPECT_FALSE(convex_hull(grid(2, 2, 1)));
  EXPECT_FALSE(convex_hull(grid(7, 7, 1)));
  std::vector<Point> tilted;
  for (const Point& p : grid(5, 5, 1)) tilted.emplace_back(p.x(), p.y(), p.x() + 2 * p.y());
  EXPECT_FALSE(convex_hull(tilted));
  tilted.emplace_back(0, 0, 1e-9);
  const auto hull = convex_hull(tilted);
  ASSERT_TRUE(hull);
  EXPECT_GT(signed_volume(*hull), 0);
}

}  // namespace
}  // namespace encage::makers
