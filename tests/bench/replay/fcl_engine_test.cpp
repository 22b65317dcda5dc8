// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/fcl_engine.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/bench/replay/bodies.h"

namespace encage::replay {
namespace {

TEST(FclEngine, FindsThePairsThatTouch) {
  test::expect_exact([](const encage::test::Sample& sample, const ShapePtr&) {
    return std::make_unique<FclEngine>(sample.hierarchy.fine);
  });
}

TEST(FclEngine, DoesNotTestWhatTheGateRejects) {
  // A gate that believes in smaller bodies rejects pairs that touch: the engine must not have asked.
  encage::test::Sample box = test::sample("box");
  FclEngine engine(box.hierarchy.fine);
  const CageGate lying(make_shape(encage::test::scaled(box, -4).hierarchy), 0);
  BodyPose a{0, Eigen::Isometry3d::Identity()}, b{1, Eigen::Isometry3d::Identity()};
  b.pose.translation().x() = 1.5;
  const PoseStep step{0, {a, b}};
  EXPECT_EQ(engine.touching(step, nullptr).size(), 1U);
  EXPECT_EQ(engine.touching(step, &lying).size(), 0U);
}

}  // namespace
}  // namespace encage::replay
