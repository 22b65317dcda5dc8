// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/gate.h"

#include "tests/bench/replay/bodies.h"

#include <gtest/gtest.h>

namespace encage::replay {
namespace {

TEST(MakePair, Sorts) {
  EXPECT_EQ(make_pair(5, 3), (BodyPair{3, 5}));
  EXPECT_EQ(make_pair(3, 5), (BodyPair{3, 5}));
}

TEST(Gates, TheFinerTheTestTheMoreItRejects) {
  const ShapePtr shape = make_shape(test::sample("star").hierarchy);
  const CageGate coarse(shape, 2), fine(shape, 0);
  const FineGate full(shape);
  int by_coarse = 0, by_fine = 0, by_full = 0;
  for (const PoseStep& step : test::crowd(20)) {
    for (std::size_t i = 1; i < step.bodies.size(); ++i) {
      by_coarse += coarse.separated(step.bodies[i - 1], step.bodies[i]);
      by_fine += fine.separated(step.bodies[i - 1], step.bodies[i]);
      by_full += full.separated(step.bodies[i - 1], step.bodies[i]);
    }
  }
  EXPECT_GT(by_full, by_fine);
  EXPECT_GT(by_fine, by_coarse);
}

TEST(Gates, DoNotRejectWhatTouches) {
  const ShapePtr shape = make_shape(test::sample("star").hierarchy);
  const BodyPose here = test::body_at(0, 0), there = test::body_at(1, 0);
  EXPECT_FALSE(CageGate(shape, 0).separated(here, there));
  EXPECT_FALSE(FineGate(shape).separated(here, there));
}

TEST(PerfectGate, RejectsAllButTheListedPairs) {
  const std::vector<BodyPair> touching = {{0, 2}, {1, 2}};
  const PerfectGate gate(touching);
  EXPECT_FALSE(gate.separated(test::body_at(2, 0), test::body_at(0, 9)));
  EXPECT_FALSE(gate.separated(test::body_at(1, 0), test::body_at(2, 9)));
  EXPECT_TRUE(gate.separated(test::body_at(0, 0), test::body_at(1, 0)));
}

}  // namespace
}  // namespace encage::replay
