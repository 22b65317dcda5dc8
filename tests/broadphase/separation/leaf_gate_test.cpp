// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/separation/leaf_gate.h"

#include "oracles/lanes.h"
#include "oracles/meshes.h"
#include "oracles/simd_targets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace encage::test {
namespace {

MovingTriangle random_triangle(shapes::Random& random, double spread) {
  MovingTriangle t;
  const Eigen::Vector3d centre = random.point(spread), way = random.point(0.2);
  for (int k = 0; k < 3; ++k) {
    t.start[k] = centre + random.point(0.5);
    t.end[k] = t.start[k] + way + random.point(0.05);
  }
  return t;
}

struct LeafPair {
  LeafLanes a, b;
  std::vector<MovingTriangle> triangles_a, triangles_b;

  LeafPair(shapes::Random& random, int ends) {
    for (int lane = 0; lane < LeafLanes::width; ++lane) {
      triangles_a.push_back(random_triangle(random, 0.5));
      triangles_b.push_back(random_triangle(random, 0.8));
      a.set(lane, triangles_a.back(), ends);
      b.set(lane, triangles_b.back(), ends);
    }
  }
};

TEST(LeafGate, AnswersForEveryLaneAsIfItWereAlone) {
  shapes::Random random(1);
  int apart = 0, near = 0;
  for (int round = 0; round < 2'000; ++round) {
    const int ends = 1 + round % 2;
    const LeafPair leaves(random, ends);
    const double distance = random(1e-9, 0.2);
    for (int lane = 0; lane < LeafLanes::width; ++lane) {
      for (int count = 1; count <= LeafLanes::width; ++count) {
        const std::uint32_t left = lanes_not_apart(leaves.a, lane, leaves.b, count, ends, distance);
        ASSERT_EQ(left >> count, 0U);
        for (int j = 0; j < count; ++j) {
          const bool alone = lanes_apart(leaves.triangles_a[lane], leaves.triangles_b[j], ends, distance);
          ASSERT_EQ((left >> j & 1U) == 0, alone) << round << " " << lane << " " << j;
          (alone ? apart : near)++;
        }
      }
    }
  }
  EXPECT_GT(apart, 10'000);
  EXPECT_GT(near, 10'000);
}

TEST(LeafGate, FindsMostOfWhatTheSlowTestsFind) {
  shapes::Random random(2);
  int slow_rest = 0, quick_rest = 0, slow_moving = 0, quick_moving = 0;
  for (int round = 0; round < 5'000; ++round) {
    const MovingTriangle a = random_triangle(random, 0.5), b = random_triangle(random, 0.8);
    const double distance = random(1e-9, 0.1);
    const bool rest = lanes_apart(a, b, 1, distance), moving = lanes_apart(a, b, 2, distance);
    slow_rest += triangles_apart(a.start, b.start, distance);
    slow_moving += moving_triangles_apart(a, b, distance);
    quick_rest += rest;
    quick_moving += moving;
  }
  EXPECT_GT(quick_rest * 100, slow_rest * 95);
  EXPECT_GT(quick_moving * 100, slow_moving * 75);
}

TEST(LeafGate, TellsTrianglesAsTheyWereSet) {
  shapes::Random random(3);
  const LeafPair leaves(random, 2);
  for (int lane = 0; lane < LeafLanes::width; ++lane) {
    const MovingTriangle t = leaves.a.triangle(lane, 2);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(t.start[k], leaves.triangles_a[lane].start[k]);
      EXPECT_EQ(t.end[k], leaves.triangles_a[lane].end[k]);
    }
  }
}

// Products of these coordinates overflow, and the gate must not prove anything then.
TEST(LeafGate, ProvesNothingByWhatOverflows) {
  shapes::Random random(4);
  for (int round = 0; round < 2'000; ++round) {
    const double scale = std::pow(10.0, random.integer(150));
    MovingTriangle a = random_triangle(random, 0.1), b = a;
    // The triangles share a corner at both ends.
    b.start[1] = random.point(1);
    b.start[2] = random.point(1);
    b.end[1] = b.start[1] + random.point(0.1);
    b.end[2] = b.start[2] + random.point(0.1);
    for (TriangleD* t : {&a.start, &a.end, &b.start, &b.end}) {
      for (Eigen::Vector3d& corner : *t) corner *= scale;
    }
    for (const int ends : {1, 2}) EXPECT_FALSE(lanes_apart(a, b, ends, 1e-12 * scale)) << scale;
    for (const double distance : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
      EXPECT_FALSE(lanes_apart(a, b, 1, distance));
      EXPECT_FALSE(lanes_apart(a, b, 2, distance));
    }
  }
}

TEST(LeafGate, AnswersTheSameOnEveryInstructionSet) {
  const auto answers = [] {
    shapes::Random random(5);
    std::vector<std::uint32_t> all;
    for (int round = 0; round < 2'000; ++round) {
      const int ends = 1 + round % 2;
      const LeafPair leaves(random, ends);
      for (int lane = 0; lane < LeafLanes::width; ++lane) {
        all.push_back(lanes_not_apart(leaves.a, lane, leaves.b, LeafLanes::width, ends, 0.05));
      }
    }
    return all;
  };
  expect_same_on_all_targets(answers);
}

}  // namespace
}  // namespace encage::test
