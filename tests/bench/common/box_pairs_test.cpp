// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/box_pairs.h"

#include "oracles/sample_shapes.h"

#include <gtest/gtest.h>

namespace encage::bench {
namespace {

/// A cube or the like, about 0.
ShapePtr block() { return make_shape(test::sample_shapes(0).front().hierarchy); }

Eigen::Isometry3d at(double x) { return Eigen::Isometry3d(Eigen::Translation3d(x, 0, 0)); }

TEST(BoxPairs, FindsOverlapsInOrder) {
  const ShapePtr shape = block();
  const double width = world_box(*shape, {}).sizes().x();
  const PoseStep step{
      0, {{4, at(0)}, {5, at(3 * width)}, {7, at(0.5 * width)}, {9, at(3.5 * width)}, {12, at(0.9 * width)}}};
  BoxPairs boxes;
  const BoxPairs::Places expected = {{0, 2}, {0, 4}, {1, 3}, {2, 4}};
  EXPECT_EQ(boxes.overlaps(*shape, step), expected);
  // Of moving bodies that rest, the same.
  std::vector<Motion> motions;
  for (const BodyPose& body : step.bodies) motions.push_back(Motion::resting(body.pose));
  EXPECT_EQ(boxes.overlaps(*shape, motions), expected);
}

TEST(BoxPairs, AMotionsBoxHoldsBothEnds) {
  const ShapePtr shape = block();
  const double width = world_box(*shape, {}).sizes().x();
  BoxPairs boxes;
  const Motion crossing{at(-3 * width), at(3 * width)}, resting = Motion::resting(at(0));
  EXPECT_EQ(boxes.overlaps(*shape, std::vector<Motion>{crossing, resting}).size(), 1U);
  EXPECT_TRUE(boxes.overlaps(*shape, {Motion::resting(crossing.start), resting}).empty());
}

}  // namespace
}  // namespace encage::bench
