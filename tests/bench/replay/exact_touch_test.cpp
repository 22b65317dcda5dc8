// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/exact_touch.h"

#include "oracles/meshes.h"
#include "tests/bench/replay/bodies.h"

#include <gtest/gtest.h>

#include <cmath>

namespace encage::replay {
namespace {

bool touch(const ExactTouch& exact, double x, double y = 0, double z = 0) {
  return exact.touch(Eigen::Isometry3d::Identity(), test::body_at(0, x, y, z).pose);
}

TEST(ExactTouch, AgreesWithBruteForce) {
  std::size_t touching = 0;
  for (const char* name : {"star", "u", "torus"}) {
    const encage::test::Sample sample = test::sample(name);
    const ExactTouch exact(sample.hierarchy.fine, true);
    for (const PoseStep& step : test::crowd(8)) {
      const std::vector<BodyPair> expected = test::exact_pairs(sample, step);
      EXPECT_EQ(exact.touching(step), expected) << name << ", step " << step.step;
      touching += expected.size();
    }
  }
  EXPECT_GT(touching, 30U);
}

TEST(ExactTouch, TellsTheLastBit) {
  const ExactTouch exact(shapes::cube(1), true);
  EXPECT_TRUE(touch(exact, 2));                          // faces
  EXPECT_TRUE(touch(exact, 2, 2));                       // edges
  EXPECT_TRUE(touch(exact, -2, 2, -2));                  // corners
  EXPECT_FALSE(touch(exact, std::nextafter(2.0, 3.0)));  // 4e-16 beside
  EXPECT_FALSE(touch(exact, 2, std::nextafter(2.0, 3.0)));
}

TEST(ExactTouch, SolidsInsideSolidsTouch) {
  const TriangleMesh mesh = shapes::joined(shapes::cube(0.25), shapes::cube(1, {6, 0, 0}));
  const ExactTouch solid(mesh, true), surface(mesh, false);
  EXPECT_TRUE(touch(solid, 6));
  EXPECT_TRUE(touch(solid, -6));
  EXPECT_FALSE(touch(surface, 6));
  EXPECT_FALSE(touch(solid, 3));
}

TEST(ExactTouch, ACavityIsNotSolid) {
  const TriangleMesh hollow = shapes::joined(shapes::cube(1.5, {6, 0, 0}), shapes::flipped(shapes::cube(1, {6, 0, 0})));
  const ExactTouch exact(shapes::joined(shapes::cube(0.25), hollow), true);
  EXPECT_FALSE(touch(exact, 6));
  EXPECT_TRUE(touch(exact, 6, 1.2));
}

}  // namespace
}  // namespace encage::replay
