// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/engine.h"

#include <gtest/gtest.h>

#include "tests/bench/replay/bodies.h"

namespace encage::replay {
namespace {

TEST(CageGate, RejectsWithTheLevelItWasGiven) {
  const ShapePtr shape = make_shape(test::sample("star").hierarchy);
  const CageGate fine(shape, 0), coarse(shape, 2);
  int by_fine = 0, by_coarse = 0;
  for (const PoseStep& step : test::crowd(10)) {
    const Eigen::Isometry3d& a = step.bodies[0].pose;
    const Eigen::Isometry3d& b = step.bodies[1].pose;
    by_fine += fine.separated(a, b);
    by_coarse += coarse.separated(a, b);
  }
  EXPECT_GT(by_fine, by_coarse);
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  EXPECT_FALSE(fine.separated(here, here));
}

}  // namespace
}  // namespace encage::replay
