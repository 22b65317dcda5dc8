// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/interpenetration.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

namespace encage::tank {
namespace {

BodyPose at(std::int32_t body, const Eigen::Vector3d& place, double angle = 0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 2) / 3).toRotationMatrix();
  pose.translation() = place;
  return {body, pose};
}

TEST(Interpenetration, CountsPairs) {
  const TriangleMesh ball = shapes::sphere(3);
  EXPECT_EQ(interpenetrations(ball, {0, {}}), 0);
  EXPECT_EQ(interpenetrations(ball, {0, {at(0, {0, 0, 0})}}), 0);
  EXPECT_EQ(interpenetrations(ball, {0, {at(0, {0, 0, 0}), at(1, {2.001, 0, 0}), at(2, {0, 2.001, 0})}}), 0);
  EXPECT_EQ(interpenetrations(ball, {0, {at(0, {0, 0, 0}), at(1, {1.9, 0, 0}), at(2, {0, 1.9, 0}), at(3, {9, 0, 0})}}),
            2);
}

TEST(Interpenetration, TouchingCounts) {
  const TriangleMesh cube = shapes::cube(1);
  EXPECT_EQ(interpenetrations(cube, {0, {at(0, {0, 0, 0}), at(1, {2, 0, 0})}}), 1);
  EXPECT_EQ(interpenetrations(cube, {0, {at(0, {0, 0, 0}), at(1, {2 + 1e-14, 2, 0})}}), 0);
}

TEST(Interpenetration, SeesThroughConcavities) {
  // Rings: linked without contact, boxes overlapping; then pushed into each other.
  const TriangleMesh ring = shapes::torus(1, 0.2, 24, 8);
  const double quarter = 3.14159265358979 / 2;
  BodyPose other = at(1, {1, 0, 0});
  other.pose.linear() = Eigen::AngleAxisd(quarter, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_EQ(interpenetrations(ring, {0, {at(0, {0, 0, 0}), other}}), 0);
  other.pose.translation().x() = 0.3;
  EXPECT_EQ(interpenetrations(ring, {0, {at(0, {0, 0, 0}), other}}), 1);
  other.pose.translation() = Eigen::Vector3d(0, 0, 0.9);
  EXPECT_EQ(interpenetrations(ring, {0, {at(0, {0, 0, 0}, 0.1), other}}), 1);
}

}  // namespace
}  // namespace encage::tank
