// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/sampled.h"

#include <encage/error.h>
#include <encage/separated.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;

std::vector<Body> candidate_bodies() {
  std::vector<Body> all;
  for (const Sample& sample : sample_shapes(0)) all.emplace_back(sample);
  all.emplace_back(scaled(sample_shapes(0)[2], -3));
  return all;
}

using Pairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

Pairs candidates(const Body& a, const Motion& motion_a, const Body& b, const Motion& motion_b, double margin) {
  Pairs pairs;
  EXPECT_TRUE(for_each_triangle_pair(*a.shape, motion_a, *b.shape, motion_b, margin, [&](TrianglePair pair) {
    pairs.emplace_back(pair.a, pair.b);
    return true;
  }));
  return pairs;
}

TEST(Candidates, AreThePairsThatComeNearAndNoOthers) {
  shapes::Random random(1);
  const std::vector<Body> all = candidate_bodies();
  std::size_t found = 0, absent = 0;
  for (int round = 0; round < 150; ++round) {
    SCOPED_TRACE(round);
    const Body &a = all[random.integer(static_cast<int>(all.size()))],
               &b = all[random.integer(static_cast<int>(all.size()))];
    const double angle = std::vector{0.0, 0.2, 3.1}[random.integer(3)];
    const double size = 0.5 * (a.diagonal() + b.diagonal());
    Pose pose_a = random_pose(random, 10), pose_b = random_pose(random, 0);
    pose_b.translation() = pose_a.translation() + random_direction(random) * random(0.3, 1) * size;
    const auto motion = [&](const Pose& pose) {
      return random.integer(6) == 0 ? Motion::resting(pose)
                                    : random_motion(random, pose, angle, angle == 3.1 ? 2 : 0.2);
    };
    const Motion motion_a = motion(pose_a), motion_b = motion(pose_b);
    const double margin = random.integer(2) == 0 ? 0 : random(0, 0.1) * size;
    // One axis has to separate for 1/256 of the step, and edges turn away from it.
    const Real gap = angle == 3.1 ? 10 : 1e-6 + 2 * size * angle / 256;
    const Pairs pairs = candidates(a, motion_a, b, motion_b, margin);
    const std::set<std::pair<std::int32_t, std::int32_t>> set(pairs.begin(), pairs.end());
    EXPECT_EQ(set.size(), pairs.size());
    const std::vector<Real> least =
        least_distances(a.mesh(), a.origin(), motion_a, b.mesh(), b.origin(), motion_b, margin + 0.02L, 24);
    const auto count_b = static_cast<std::int32_t>(b.mesh().triangles.rows());
    for (std::int32_t i = 0; i < a.mesh().triangles.rows(); ++i) {
      for (std::int32_t j = 0; j < count_b; ++j) {
        const Real value = least[i * count_b + j];
        const bool is_found = set.count({i, j}) != 0;
        if (!is_found) {
          ++absent;
          ASSERT_GT(value, margin) << i << " " << j;
          continue;
        }
        ++found;
        if (value <= margin + gap) continue;
        // The least distance may be between the samples.
        const Real nearest = least_value([&](Real t) {
          return triangle_distance(at_time(a.mesh(), a.origin(), motion_a, t)[i],
                                   at_time(b.mesh(), b.origin(), motion_b, t)[j]);
        });
        EXPECT_LE(nearest, margin + gap) << i << " " << j;
      }
    }
  }
  EXPECT_GT(found, 2'000U);
  EXPECT_GT(absent, 20'000U);
}

TEST(Candidates, StopWhenAskedTo) {
  const Body box(sample_shapes(0)[1]);
  const Motion rest = Motion::resting(Pose::Identity());
  for (const int stop_after : {1, 5}) {
    int calls = 0;
    EXPECT_FALSE(for_each_triangle_pair(*box.shape, rest, *box.shape, rest, 0.1,
                                        [&](TrianglePair) { return ++calls < stop_after; }));
    EXPECT_EQ(calls, stop_after);
  }
  // The same pairs come in the same order every time.
  EXPECT_EQ(candidates(box, rest, box, rest, 0.1), candidates(box, rest, box, rest, 0.1));
}

TEST(Candidates, OfUnusableMotionsAreRefused) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const Body box(sample_shapes(0)[1]);
  Motion rest = Motion::resting(Pose::Identity()), far = rest;
  far.start.translation().x() = far.end.translation().x() = 100;
  int calls = 0;
  const auto count = [&](const Motion& motion, double margin) {
    return candidates(box, rest, box, motion, margin).size();
  };
  const auto message = [&](const Motion& a, const Motion& b, double margin) -> std::string {
    try {
      for_each_triangle_pair(*box.shape, a, *box.shape, b, margin, [&](TrianglePair) { return ++calls > 0; });
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(count(far, 0), 0U);
  EXPECT_EQ(count(far, infinity), 144U);
  EXPECT_EQ(message(rest, far, nan), "triangle pairs: the margin nan is negative or not a number");
  EXPECT_EQ(message(rest, far, -1), "triangle pairs: the margin -1 is negative or not a number");
  for (const double bad : {nan, infinity}) {
    Motion spoiled = far;
    spoiled.end.translation().y() = bad;
    EXPECT_EQ(message(rest, spoiled, 0), "triangle pairs: body b: the end pose is not finite");
    EXPECT_EQ(message(spoiled, rest, 0), "triangle pairs: body a: the end pose is not finite");
  }
  Motion turned = far, mirrored = far;
  turned.end.linear() = Vector(-1, -1, 1).asDiagonal();
  mirrored.start.linear() = Vector(-1, 1, 1).asDiagonal();
  EXPECT_EQ(
      message(rest, turned, 0),
      "triangle pairs: body b: the rotation within the step reaches 180 degrees: split it, e.g. by split_motion()");
  EXPECT_EQ(message(mirrored, rest, 0), "triangle pairs: body a: the start pose mirrors the body");
  EXPECT_EQ(message(Motion::resting(Pose::Identity(), 0), rest, 0),
            "triangle pairs: body a: the scale 0 is not between 1e-50 and 1e50");
  EXPECT_EQ(calls, 0);
}

TEST(Candidates, AreNoneWithoutAFineMesh) {
  const Body box(sample_shapes(0)[1]), bare(without_fine(sample_shapes(0)[1]));
  const Motion rest = Motion::resting(Pose::Identity());
  EXPECT_TRUE(candidates(box, rest, bare, rest, 1).empty());
  EXPECT_TRUE(candidates(bare, rest, box, rest, 1).empty());
}

TEST(Candidates, FineErrorCounts) {
  Sample sample = without_cages(sample_shapes(0)[1]);
  sample.hierarchy.fine_error = 0.01;
  const Body box(sample);
  const auto any = [&](double x) {
    Pose pose = Pose::Identity();
    pose.translation().x() = x;
    return !candidates(box, Motion::resting(Pose::Identity()), box, Motion::resting(pose), 0).empty();
  };
  EXPECT_TRUE(any(2.0199));
  EXPECT_FALSE(any(2.0201));
}

CageHierarchy without_cages(TriangleMesh mesh, Solid solid) {
  CageHierarchy h;
  h.fine = std::move(mesh);
  h.fine.vertices = h.fine.vertices.cast<float>().cast<double>().eval();
  h.solid = solid;
  h.diagonal = 1;
  return h;
}

// Regression: with a grid step derived from the sheet's thickness, grid coordinates overflowed, and spheres through the
// sheet were "separated".
TEST(Candidates, AreFoundOnSheetsThatAreFlatAcrossAnAxis) {
  for (int across = 0; across < 3; ++across) {
    const ShapePtr flat = make_shape(without_cages(sheet(32, across, 10), Solid::surface_only));
    for (const double radius : {1e-3, 2.0, 4.0, 5.0, 8.0, 20.0}) {
      TriangleMesh ball = shapes::sphere(4);
      ball.vertices *= radius;
      const ShapePtr sphere = make_shape(without_cages(ball, Solid::closed));
      for (int turn = 0; turn < 20; ++turn) {
        Pose pose = Pose::Identity();
        pose.linear() = Eigen::AngleAxisd(0.37 * turn, Vector(1, 2, 3 + turn).normalized()).toRotationMatrix();
        pose.translation()[across] = radius * 0.9;
        for (const Motion& motion :
             {Motion::resting(pose), Motion{pose, Pose(Eigen::Translation3d(0, 0, 0.01) * pose)}}) {
          const Motion still = Motion::resting(Pose::Identity());
          EXPECT_FALSE(separated(*flat, still, *sphere, motion).separated) << across << " " << radius << " " << turn;
          EXPECT_FALSE(for_each_triangle_pair(*flat, still, *sphere, motion, 0, [](TrianglePair) { return false; }));
          EXPECT_FALSE(for_each_triangle_pair(*sphere, motion, *flat, still, 0, [](TrianglePair) { return false; }));
        }
      }
    }
  }
}

}  // namespace
}  // namespace encage::test
