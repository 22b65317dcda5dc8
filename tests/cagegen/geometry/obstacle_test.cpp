// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/obstacle.h"

#include "cagegen/certify/separation.h"
#include "tests/cagegen/geometry/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace encage::makers {
namespace {

using shapes::Random;

/// Triangles of all kinds around a point.
TriangleMesh soup(Random& random, int count, const Point& centre, double size) {
  TriangleMesh mesh;
  mesh.vertices.resize(3 * count, 3);
  mesh.triangles.resize(count, 3);
  for (int t = 0; t < count; ++t) {
    const Corners corners = shapes::awkward_triangle(random, size);
    const Point shift = centre + random.point(1);
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.row(3 * t + k) = (corners[k] + shift).transpose();
      mesh.triangles(t, k) = 3 * t + k;
    }
  }
  return mesh;
}

Prism random_prism(Random& random, const Point& centre) {
  for (;;) {
    const double size = random(0.01, 1);
    const Point a = centre + random.point(1);
    const Prism prism({a, a + size * random.point(1), a + size * random.point(1)});
    if (prism.valid) return prism;
  }
}

std::vector<Point> centres() { return {Point(0, 0, 0), Point(4, -3, 2), Point(15, 15, -15)}; }

TEST(Prism, PlanesFaceOutward) {
  Random random(41);
  for (int i = 0; i < 1000; ++i) {
    const Prism prism = random_prism(random, {3, 2, 1});
    const Point middle = (prism.corner[0] + prism.corner[1] + prism.corner[2]) / 3;
    EXPECT_NEAR(prism.normal.norm(), 1, 1e-12);
    EXPECT_NEAR(prism.height(middle + 0.5 * prism.normal), 0.5, 1e-9);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(prism.side[k].dot(prism.normal), 0, 1e-9);
      EXPECT_LT(prism.side[k].dot(middle - prism.corner[k]), 0);
      EXPECT_NEAR(prism.side[k].dot(prism.corner[(k + 1) % 3] - prism.corner[k]), 0, 1e-9);
    }
  }
  EXPECT_FALSE(Prism({Point(1, 2, 3), Point(2, 4, 6), Point(0, 0, 0)}).valid);
}

TEST(Obstacle, HitsAgainstAllTriangles) {
  Random random(42);
  for (const Point& centre : centres()) {
    for (const double size : {0.05, 0.5}) {
      const Obstacle obstacle(soup(random, 400, centre, size));
      ASSERT_EQ(obstacle.size(), 400u);
      std::size_t total = 0;
      for (int i = 0; i < 200; ++i) {
        const Prism prism = random_prism(random, centre);
        const double clearance = std::pow(10.0, random(-6, -0.5));
        std::vector<std::int32_t> found;
        obstacle.hits(prism, clearance, obstacle.size(), found);
        std::sort(found.begin(), found.end());
        EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
        total += found.size();
        for (std::int32_t t = 0; t < 400; ++t) {
          const bool hit = std::binary_search(found.begin(), found.end(), t);
          if (separated(prism.corner, obstacle.corners(t), clearance)) {
            EXPECT_FALSE(hit) << "proven to be farther";
          } else if (proof::separate(prism.corner, obstacle.corners(t)).upper <= clearance) {
            EXPECT_TRUE(hit) << "too close";
          }
        }
        EXPECT_EQ(obstacle.hit(prism, clearance), !found.empty());
        std::vector<std::int32_t> some{-7};
        obstacle.hits(prism, clearance, 4, some);
        EXPECT_EQ(some.size(), std::min<std::size_t>(4, 1 + found.size())) << "at most so many in all";
        EXPECT_EQ(some[0], -7);
      }
      EXPECT_GT(total, 50u);
    }
  }
}

TEST(Obstacle, HitsOfSlivers) {
  // Three points on a line, but for rounding: the normal is any direction, along the line too.
  Random random(47);
  const Obstacle obstacle(soup(random, 400, {0, 0, 0}, 0.5));
  int slivers = 0;
  std::size_t total = 0;
  for (int i = 0; i < 4000; ++i) {
    const Point a = random.point(1);
    const Point b = random.point(1);
    const Prism prism({a, b, a + random(0, 1) * (b - a)});
    if (!prism.valid) continue;
    ++slivers;
    std::vector<std::int32_t> found;
    obstacle.hits(prism, 1e-3, obstacle.size(), found);
    std::sort(found.begin(), found.end());
    for (std::int32_t t = 0; t < 400; ++t) {
      if (proof::separate(prism.corner, obstacle.corners(t)).upper > 0.9e-3) continue;
      ++total;
      EXPECT_TRUE(std::binary_search(found.begin(), found.end(), t)) << i << ' ' << t;
    }
  }
  EXPECT_GT(slivers, 2000);
  EXPECT_GT(total, 200u);
}

TEST(Obstacle, WorkCountsTheTriangles) {
  Random random(43);
  const Obstacle obstacle(soup(random, 50, Point::Zero(), 0.5));
  const std::uint64_t before = Obstacle::work();
  std::vector<std::int32_t> found;
  obstacle.hits(random_prism(random, Point::Zero()), 10, obstacle.size(), found);
  EXPECT_EQ(found.size(), 50u);
  EXPECT_EQ(Obstacle::work() - before, 50u);
}

TEST(Obstacle, SteepestIsTheMaximumOverAllTriangles) {
  Random random(44);
  int raised = 0;
  for (const Point& centre : centres()) {
    for (const double size : {0.05, 0.5}) {
      const Obstacle obstacle(soup(random, 300, centre, size));
      for (int i = 0; i < 200; ++i) {
        const Prism prism = random_prism(random, centre);
        const double lift = std::pow(10.0, random(-6, -2));
        const double ceiling = random(0, 0.5);
        const double slope = i % 2 ? 0 : random(0, 3);
        double expected = slope;
        for (std::int32_t t = 0; t < 300; ++t) {
          expected = std::max(expected, Obstacle::steepest(prism, obstacle.corners(t), lift, ceiling, slope));
        }
        const double found = obstacle.steepest(prism, lift, ceiling, slope);
        EXPECT_NEAR(found, expected, 1e-9 * (1 + expected));
        raised += expected > slope;
      }
    }
  }
  EXPECT_GT(raised, 300);
}

TEST(Obstacle, NothingInThePrismStaysAboveTheSteepestPlane) {
  Random random(45);
  int tested = 0;
  for (int i = 0; i < 4000; ++i) {
    const Prism prism = random_prism(random, Point::Zero());
    Corners t = shapes::awkward_triangle(random, 0.7);
    for (Point& p : t) p += (prism.corner[0] + prism.corner[1] + prism.corner[2]) / 3;
    const auto from_edge = [&](const Point& x) { return -prism.side[1].dot(x - prism.corner[1]); };
    // What stands over the edge itself, no turn about it puts under the plane.
    if (std::any_of(t.begin(), t.end(), [&](const Point& p) { return from_edge(p) < 1e-6; })) continue;
    const double lift = 1e-6;
    const double ceiling = 0.4;
    const double slope = Obstacle::steepest(prism, t, lift, ceiling, 0);
    for (int sample = 0; sample < 30; ++sample) {
      double a = random(0, 1), b = random(0, 1);
      if (a + b > 1) a = 1 - a, b = 1 - b;
      const Point x = t[0] + a * (t[1] - t[0]) + b * (t[2] - t[0]);
      bool inside = prism.height(x) <= ceiling;
      for (int k = 0; k < 3; ++k) inside = inside && prism.side[k].dot(x - prism.corner[k]) <= 0;
      if (!inside) continue;
      ++tested;
      EXPECT_LE(prism.height(x), slope * from_edge(x) + 1e-9) << i;
    }
  }
  EXPECT_GT(tested, 3000);
}

TEST(Obstacle, Steepest) {
  // The triangle (0, 1, 2) in the plane z = 0, turning about the edge y = 0.
  const Prism prism({Point(1, 2, 0), Point(0, 0, 0), Point(2, 0, 0)});
  ASSERT_TRUE(prism.normal.isApprox(Point(0, 0, 1)));
  const auto small = [](const Point& p) { return Corners{p, p + Point(1e-9, 0, 0), p + Point(0, 1e-9, 0)}; };
  const auto steepest = [&](const Point& p, double slope) { return Obstacle::steepest(prism, small(p), 0, 1, slope); };
  EXPECT_NEAR(steepest({1, 1, 0.5}, 0), 0.5, 1e-6);
  EXPECT_NEAR(steepest({1, 0.25, 0.5}, 0), 2, 1e-6);
  EXPECT_EQ(steepest({1, 1, 0.5}, 0.7), 0.7) << "already under the plane";
  EXPECT_EQ(steepest({1, 1, -0.5}, 0), 0) << "below";
  EXPECT_EQ(steepest({1, 1, 1.5}, 0), 0) << "above the ceiling";
  EXPECT_EQ(steepest({1, -1, 0.5}, 0), 0) << "beyond the edge";
  EXPECT_EQ(steepest({3, 1, 0.5}, 0), 0) << "beside the prism";
}

TEST(Obstacle, HighestCornerOverATriangle) {
  Random random(46);
  int raised = 0;
  for (const Point& centre : centres()) {
    const Obstacle obstacle(soup(random, 400, centre, 0.3));
    for (int i = 0; i < 300; ++i) {
      const Prism prism = random_prism(random, centre);
      const double ceiling = random(0, 1);
      double expected = 0;
      for (std::int32_t t = 0; t < 400; ++t) {
        for (const Point& p : obstacle.corners(t)) {
          bool over = prism.height(p) <= ceiling;
          for (int k = 0; k < 3; ++k) over = over && prism.side[k].dot(p - prism.corner[k]) <= 0;
          if (over) expected = std::max(expected, prism.height(p));
        }
      }
      EXPECT_EQ(obstacle.highest(prism, ceiling, 0), expected);
      EXPECT_EQ(obstacle.highest(prism, ceiling, 0.3), std::max(expected, 0.3));
      raised += expected > 0;
    }
  }
  EXPECT_GT(raised, 200);
}

TEST(Obstacle, MoveIsAsGoodAsNew) {
  Random random(48);
  for (const Point& centre : centres()) {
    TriangleMesh mesh = soup(random, 300, centre, 0.3);
    Obstacle moving(mesh);
    for (int round = 0; round < 5; ++round) {
      const double by = std::pow(10.0, -round);
      for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) mesh.vertices.row(v) += random.point(by).transpose();
      // Far away and back: nothing of the first move may stay.
      moving.move(Vertices(mesh.vertices.array() * 100));
      moving.move(mesh.vertices);
      const Obstacle fresh(mesh);
      EXPECT_EQ(moving.magnitude(), fresh.magnitude());
      EXPECT_EQ(moving.representatives(), fresh.representatives());
      std::size_t total = 0;
      for (int i = 0; i < 60; ++i) {
        const Prism prism = random_prism(random, centre);
        const double clearance = std::pow(10.0, random(-6, -0.5));
        // Their numbers differ: compare positions.
        const auto hits = [&](const Obstacle& obstacle) {
          std::vector<std::int32_t> found;
          obstacle.hits(prism, clearance, obstacle.size(), found);
          std::vector<std::array<double, 9>> places;
          for (const std::int32_t t : found) {
            places.emplace_back();
            for (int k = 0; k < 9; ++k) places.back()[k] = obstacle.corners(t)[k / 3][k % 3];
          }
          std::sort(places.begin(), places.end());
          return places;
        };
        EXPECT_EQ(hits(moving), hits(fresh));
        total += hits(fresh).size();
        std::vector<Point> points;
        moving.representatives(Eigen::AlignedBox3d(centre - Point(1, 1, 1), centre + Point(1, 1, 1)), points);
        for (const Point& p : fresh.representatives()) {
          const bool inside = (p - centre).cwiseAbs().maxCoeff() <= 1;
          EXPECT_TRUE(!inside || std::find(points.begin(), points.end(), p) != points.end());
        }
      }
      EXPECT_GT(total, 50u);
    }
  }
}

TEST(Obstacle, HighestHitsAreTheHits) {
  Random random(49);
  for (const Point& centre : centres()) {
    const Obstacle obstacle(soup(random, 400, centre, 0.3));
    for (int i = 0; i < 200; ++i) {
      const Prism prism = random_prism(random, centre);
      const double clearance = std::pow(10.0, random(-6, -0.5));
      std::vector<std::int32_t> hits;
      std::vector<std::int32_t> highest;
      obstacle.hits(prism, clearance, obstacle.size(), hits);
      obstacle.highest_hits(prism, clearance, obstacle.size(), highest);
      std::vector<std::int32_t> some{-7};
      obstacle.highest_hits(prism, clearance, 5, some);
      EXPECT_EQ(some.size(), std::min<std::size_t>(5, 1 + hits.size())) << "at most so many in all";
      EXPECT_TRUE(std::equal(some.begin() + 1, some.end(), highest.begin()));
      std::sort(hits.begin(), hits.end());
      std::sort(highest.begin(), highest.end());
      EXPECT_EQ(hits, highest);
    }
  }
}

TEST(Obstacle, HighestHitsComeHighestFirst) {
  // Points at random heights over one triangle: four, one node of the tree, whose boxes are the points.
  Random random(50);
  const Prism prism({Point(0, 0, 0), Point(4, 0, 0), Point(0, 4, 0)});
  for (int round = 0; round < 100; ++round) {
    TriangleMesh mesh;
    mesh.vertices.resize(4, 3);
    mesh.triangles.resize(4, 3);
    for (int i = 0; i < 4; ++i) {
      mesh.vertices.row(i) << random(0.5, 1.5), random(0.5, 1.5), random(-0.5, 0.5);
      mesh.triangles.row(i).setConstant(i);
    }
    const Obstacle obstacle(mesh);
    std::vector<std::int32_t> found;
    obstacle.highest_hits(prism, 1, 4, found);
    ASSERT_EQ(found.size(), 4u);
    for (int i = 1; i < 4; ++i) {
      EXPECT_GE(obstacle.corners(found[i - 1])[0].z(), obstacle.corners(found[i])[0].z() - 1e-5);
    }
  }
}

TEST(Obstacle, NearHoldsForBoxesFarFromTheObstacle) {
  // Boxes that touch the prism's triangle, of something that reaches farther than the obstacle.
  Random random(51);
  const Obstacle nothing{TriangleMesh()};
  for (int i = 0; i < 20000; ++i) {
    const double size = std::pow(10.0, random(-1, 3));
    const Prism prism({random.point(size), random.point(size), random.point(size)});
    double a = random(0, 1), b = random(0, 1);
    if (a + b > 1) a = 1 - a, b = 1 - b;
    const Point x = prism.corner[0] + a * (prism.corner[1] - prism.corner[0]) + b * (prism.corner[2] - prism.corner[0]);
    Eigen::AlignedBox3d box(x);
    box.extend(x + random.point(i % 2 ? 100 * size : 0));
    int found = 0;
    TriangleTree(std::span(&box, 1)).traverse(nothing.near(prism, 0, 101 * size), [&](std::int32_t) { ++found; });
    EXPECT_EQ(found, 1) << i;
  }
}

TEST(Obstacle, OneRepresentativeAComponent) {
  TriangleMesh mesh = shapes::cube(1);
  for (int i = 1; i < 40; ++i) mesh = shapes::joined(mesh, shapes::tetrahedron(0.1, {3.0 * i, 0, 0}));
  const Obstacle obstacle(mesh);
  EXPECT_EQ(obstacle.magnitude(), 117.1);
  std::vector<Point> found;
  obstacle.representatives(Eigen::AlignedBox3d(Point(-200, -200, -200), Point(200, 200, 200)), found);
  EXPECT_EQ(found.size(), 40u);
  Random random(47);
  for (int i = 0; i < 100; ++i) {
    const double low = random(-2, 110), high = low + random(0, 30);
    found.clear();
    obstacle.representatives(Eigen::AlignedBox3d(Point(low, -2, -2), Point(high, 2, 2)), found);
    std::vector<bool> seen(40);
    for (const Point& p : found) {
      EXPECT_TRUE(p.x() >= low - 0.01 && p.x() <= high + 0.01);
      const auto component = static_cast<std::size_t>(std::lround(p.x() / 3));
      EXPECT_FALSE(seen[component]) << "twice";
      seen[component] = true;
    }
    // Whatever lies in the box as a whole has its point there.
    for (int c = 1; c < 40; ++c) {
      const bool inside = 3.0 * c >= low && 3.0 * c + 0.1 <= high;
      EXPECT_TRUE(!inside || seen[c]);
    }
  }
}

}  // namespace
}  // namespace encage::makers
