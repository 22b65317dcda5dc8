// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/recorded_poses.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace encage::bench {
namespace {

BodyPose at(std::int32_t body, double x, double angle = 0) {
  BodyPose pose{body, Eigen::Isometry3d(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()))};
  pose.pose.translation().x() = x;
  return pose;
}

TEST(RecordedPoses, ABodyMovesToItsNextPose) {
  const Recording recording = recording_of({{10, {at(0, 1), at(3, 2)}}, {11, {at(0, 5), at(3, 6)}}}, 0.5, 1, "p.csv");
  EXPECT_EQ(recording.dt, 0.5);
  ASSERT_EQ(recording.steps.size(), 1U);
  EXPECT_EQ(recording.steps[0].step, 10);
  ASSERT_EQ(recording.steps[0].bodies.size(), 2U);
  EXPECT_EQ(recording.steps[0].bodies[1].body, 3);
  EXPECT_EQ(recording.steps[0].bodies[1].motion.start.translation().x(), 2);
  EXPECT_EQ(recording.steps[0].bodies[1].motion.end.translation().x(), 6);
}

TEST(RecordedPoses, BodiesThatTheNextStepLacksAreLeftOut) {
  const Recording recording =
      recording_of({{0, {at(0, 1), at(1, 2), at(2, 3)}}, {1, {at(0, 1), at(2, 3), at(5, 1)}}}, 1, 1, "p.csv");
  ASSERT_EQ(recording.steps.at(0).bodies.size(), 2U);
  EXPECT_EQ(recording.steps[0].bodies[0].body, 0);
  EXPECT_EQ(recording.steps[0].bodies[1].body, 2);
}

TEST(RecordedPoses, TakesEveryKthStepWithItsNeighbour) {
  std::vector<PoseStep> poses;
  for (int i = 0; i < 7; ++i) poses.push_back({i, {at(0, i)}});
  const Recording recording = recording_of(poses, 1, 3, "p.csv");
  ASSERT_EQ(recording.steps.size(), 2U);  // 0 and 3; 6 has no next pose
  EXPECT_EQ(recording.steps[1].step, 3);
  EXPECT_EQ(recording.steps[1].bodies[0].motion.end.translation().x(), 4);
}

TEST(RecordedPoses, NamesABodyThatTurnsTooFar) {
  try {
    recording_of({{4, {at(2, 0)}}, {5, {at(2, 0, 3.1415926535)}}}, 1, 1, "p.csv");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("p.csv: step 4, body 2"), std::string::npos) << error.what();
  }
}

TEST(RecordedPoses, OneStepIsNoMotion) { EXPECT_THROW(recording_of({{0, {at(0, 0)}}}, 1, 1, "p.csv"), Error); }

TEST(TrajectoryHash, DependsOnEveryPoseAndTheirOrder) {
  const std::vector<PoseStep> poses = {{0, {at(0, 1), at(1, 2)}}, {1, {at(0, 3), at(1, 4)}}};
  EXPECT_EQ(trajectory_hash(poses), trajectory_hash(poses));
  std::vector<PoseStep> other = poses;
  std::swap(other[0], other[1]);
  EXPECT_NE(trajectory_hash(poses), trajectory_hash(other));
  other = poses;
  other[1].bodies[1] = at(1, 4.000000001);
  EXPECT_NE(trajectory_hash(poses), trajectory_hash(other));
}

}  // namespace
}  // namespace encage::bench
