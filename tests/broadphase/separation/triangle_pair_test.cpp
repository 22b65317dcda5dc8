// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/separation/triangle_pair.h"

#include "oracles/exact_pair.h"
#include "oracles/lanes.h"
#include "oracles/sampled.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

// A caller's allowance for rounding, for corners within `size`.
double slack(double size) { return 1e-14 * size; }

class TrianglePairs : public testing::Test {
 protected:
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector point() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  Vector lattice_point() { return (point() * 3).array().round(); }
  TriangleD triangle() {
    TriangleD t{point(), point(), point()};
    const unsigned kind = random_() % 8;
    if (kind == 0) t[2] = t[0] + (t[1] - t[0]) * uniform(-0.5, 1.5);  // nearly collinear
    if (kind == 1) t[2] = t[1];                                       // a segment
    if (kind == 2) t = {t[0], t[0], t[0]};                            // a point
    return t;
  }
  std::minstd_rand random_{11};
};

TEST_F(TrianglePairs, NeverApartWhenTheyMeet) {
  int apart = 0, meeting = 0;
  for (int i = 0; i < 20'000; ++i) {
    TriangleD a = triangle(), b = triangle();
    if (i % 3 == 0) {
      for (int k = 0; k < 3; ++k) a[k] = lattice_point(), b[k] = lattice_point();
    }
    const double margin = i % 2 == 0 ? 0 : uniform(0, 0.5);
    const bool said = triangles_apart(a, b, margin + slack(6));
    const bool meet = test::triangles_meet(a, b, margin);
    apart += said;
    meeting += meet;
    ASSERT_FALSE(said && meet) << "pair " << i;
    // The test is complete: it separates all triangles that are farther apart by little more than the slack.
    if (!meet && !test::triangles_meet(a, b, margin + 1e-9)) {
      ASSERT_TRUE(said) << "pair " << i;
    }
  }
  EXPECT_GT(apart, 5'000);
  EXPECT_GT(meeting, 3'000);
}

TEST_F(TrianglePairs, TinyAxesDoNotShrinkTheMargin) {
  // The edges are almost parallel: their cross product is so short that its squares underflow.
  const TriangleD a{Vector(-10, 0, 0), Vector(1, 0, 0), Vector(0, 1, 0)};
  for (const double turn : {1e-100, 1e-150, 1e-160, 2.3636e-164, 2.4546e-164, 1e-170, 1e-300}) {
    for (const double z : {0.85, 0.9, 0.99}) {
      const TriangleD b{Vector(0, 0, z), Vector(10, 10 * turn, z), Vector(-turn, 1, z)};
      EXPECT_FALSE(triangles_apart(a, b, 1)) << turn << " at " << z;
      EXPECT_FALSE(triangles_apart(b, a, 1)) << turn << " at " << z;
      EXPECT_TRUE(triangles_apart(a, b, 0.8)) << turn << " at " << z;
    }
  }
}

TEST_F(TrianglePairs, NearContactOfEveryFeaturePair) {
  // Two features touch, and are then moved along their common normal until they miss by `gap`.
  const TriangleD a = {Vector(0, 0, 0), Vector(1, 0, 0), Vector(0, 1, 0)};
  const std::vector<TriangleD> placed = {
      {Vector(0.2, 0.2, 0), Vector(0.1, 0.3, 1), Vector(0.4, 0.2, 1)},         // vertex above the face
      {Vector(0.5, -0.5, -0.5), Vector(0.5, 0.5, 0.5), Vector(0.5, -0.5, 1)},  // edge over edge
      {Vector(0, 0, 0), Vector(-1, 0, 0.5), Vector(-1, 1, 0.5)},               // vertex at a vertex
      {Vector(0.5, 0, 0), Vector(0.2, -1, 0), Vector(0.8, -1, 0)},             // coplanar, vertex at an edge
      {Vector(0, 0, 0), Vector(1, 0, 0), Vector(0, -1, 0)},                    // coplanar, edge at an edge
      {Vector(0, 0, 0), Vector(1, 0, 0), Vector(0, 1, 0)},                     // face upon face
  };
  const std::vector<Vector> direction = {Vector(0, 0, 1),  Vector(0, -1, 1).normalized(),
                                         Vector(-1, 0, 0), Vector(0, -1, 0),
                                         Vector(0, -1, 0), Vector(0, 0, 1)};
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (double gap = 1e-12; gap < 10; gap *= 10) {
      TriangleD b = placed[i];
      for (Vector& v : b) v += direction[i] * gap;
      EXPECT_FALSE(test::triangles_meet(a, b, 0)) << i << " at " << gap;
      EXPECT_TRUE(triangles_apart(a, b, slack(2))) << i << " at " << gap;
    }
    EXPECT_TRUE(test::triangles_meet(a, placed[i], 0)) << i;
    EXPECT_FALSE(triangles_apart(a, placed[i], slack(2))) << i;
  }
}

// ---- Moving ----------------------------------------------------------------

test::RealTriangle at(const MovingTriangle& m, test::Real t) {
  test::RealTriangle result;
  for (int k = 0; k < 3; ++k) result[k] = (1 - t) * m.start[k].cast<test::Real>() + t * m.end[k].cast<test::Real>();
  return result;
}

/// Least distance during the motion.
test::Real least_distance(const MovingTriangle& a, const MovingTriangle& b) {
  return test::least_value([&](test::Real t) { return test::triangle_distance(at(a, t), at(b, t)); });
}

class MovingTrianglePairs : public TrianglePairs {
 protected:
  /// Returns a motion that is nearly rigid, or any motion.
  MovingTriangle moving(double turn, double way) {
    MovingTriangle m;
    m.start = triangle();
    const Eigen::Matrix3d r = Eigen::AngleAxisd(uniform(-turn, turn), point().normalized()).toRotationMatrix();
    const Vector d = point() * way;
    for (int k = 0; k < 3; ++k) m.end[k] = r * m.start[k] + d;
    return m;
  }
  static void shift(MovingTriangle& m, const Vector& by) {
    for (int k = 0; k < 3; ++k) m.start[k] += by, m.end[k] += by;
  }
};

TEST_F(MovingTrianglePairs, NeverApartWhenTheyComeNear) {
  int full = 0, quick = 0, near = 0;
  for (int i = 0; i < 1'500; ++i) {
    MovingTriangle a = moving(i % 2 == 0 ? 3 : 0.3, 1), b = moving(i % 2 == 0 ? 3 : 0.3, 1);
    if (i % 4 == 0) a.end = triangle(), b.end = triangle();  // not a rigid motion
    shift(b, point() * 1.5);
    const double margin = i % 3 == 0 ? 0 : uniform(0, 0.5);
    const bool said = moving_triangles_apart(a, b, margin + slack(6));
    const bool said_quickly = test::lanes_apart(a, b, 2, margin + slack(6));
    const test::Real least = least_distance(a, b);
    full += said;
    quick += said_quickly;
    near += least <= margin;
    // A distance at a sampled time is a distance of the motion.
    ASSERT_FALSE(said && least <= margin) << "pair " << i;
    ASSERT_FALSE(said_quickly && least <= margin) << "pair " << i;
  }
  EXPECT_GT(full, 400);
  EXPECT_GT(quick, 300);
  EXPECT_GT(near, 150);
}

TEST_F(MovingTrianglePairs, FindsWhatIsApartByLittle) {
  for (const double turn : {0.0, 0.01, 0.3}) {
    // One axis has to separate for 1/256 of the step; edges of length 3 turn away from it by their turn in half of
    // that.
    const double least_gap = 1e-6 + 2 * 3 * turn / 512;
    int asked = 0, quick = 0;
    for (int i = 0; i < 500; ++i) {
      MovingTriangle a = moving(turn, 0.01), b = moving(turn, 0.01);
      shift(b, point() * 2);
      const auto least = static_cast<double>(least_distance(a, b));
      if (least <= 2 * least_gap) continue;
      ++asked;
      ASSERT_TRUE(moving_triangles_apart(a, b, least - least_gap)) << "pair " << i << ", " << turn;
      quick += test::lanes_apart(a, b, 2, 0.5 * least);
    }
    EXPECT_GT(asked, 300);
    EXPECT_GT(quick * 10, asked * 8);
  }
}

TEST_F(MovingTrianglePairs, AtRestTheSameAsTriangles) {
  for (int i = 0; i < 3'000; ++i) {
    const TriangleD a = triangle(), b = triangle();
    const double distance = uniform(0, 1);
    EXPECT_EQ(moving_triangles_apart({a, a}, {b, b}, distance), triangles_apart(a, b, distance)) << "pair " << i;
    for (const int ends : {1, 2}) {
      if (test::lanes_apart({a, a}, {b, b}, ends, distance)) {
        EXPECT_TRUE(triangles_apart(a, b, distance - 1e-9)) << "pair " << i;
      }
    }
  }
}

TEST_F(MovingTrianglePairs, WhatPassesThroughIsNotApart) {
  const TriangleD face{Vector(0, 0, 0), Vector(1, 0, 0), Vector(0, 1, 0)};
  for (const double height : {1e-6, 1.0, 1e3, 1e6}) {
    MovingTriangle m;
    for (int k = 0; k < 3; ++k) {
      m.start[k] = 0.1 * face[k] + Vector(0.2, 0.2, height);
      m.end[k] = 0.1 * face[k] + Vector(0.2, 0.2, -height);
    }
    EXPECT_FALSE(moving_triangles_apart({face, face}, m, 1e-12 * height));
    EXPECT_FALSE(test::lanes_apart({face, face}, m, 2, 1e-12 * height));
    // The second triangle moves beside the first one at the same speed.
    shift(m, Vector(2, 0, 0));
    EXPECT_TRUE(moving_triangles_apart({face, face}, m, 1e-9));
  }
}

}  // namespace
}  // namespace encage
