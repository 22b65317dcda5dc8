// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/motion/pose.h"

#include "oracles/body.h"
#include "oracles/sampled.h"

#include <encage/shape.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;

constexpr double degree = 3.14159265358979323846 / 180;

Pose turned(double angle, const Vector& axis, const Vector& at = Vector::Zero()) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  pose.translation() = at;
  return pose;
}

TEST(Poses, AreRigidWithinATolerance) {
  EXPECT_TRUE(is_usable(Pose::Identity()));
  shapes::Random random(3);
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(is_usable(random_pose(random, 1e6)));
  Pose stretched = Pose::Identity();
  stretched.linear()(1, 1) = 1 + 4e-10;
  EXPECT_TRUE(is_usable(stretched));
  EXPECT_GE(departure_from_rigid(stretched.linear()), 8e-10);
  stretched.linear()(1, 1) = 1 + 6e-10;
  EXPECT_FALSE(is_usable(stretched));
  Pose bad = Pose::Identity();
  bad.translation().y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(is_usable(bad));
}

TEST(Poses, DoNotMirror) {
  shapes::Random random(4);
  for (int i = 0; i < 100; ++i) {
    Pose mirrored = random_pose(random, 10);
    EXPECT_FALSE(is_mirrored(mirrored));
    mirrored.linear().col(random.integer(3)) *= -1;
    EXPECT_LT(departure_from_rigid(mirrored.linear()), 1e-12);
    EXPECT_TRUE(is_mirrored(mirrored));
    EXPECT_FALSE(is_usable(mirrored));
    EXPECT_FALSE(is_usable(Motion::resting(mirrored)));
  }
}

TEST(UsableMotions, TurnBelow180Degrees) {
  shapes::Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Pose start = random_pose(random, 100);
    const Vector axis = random_direction(random);
    const auto usable = [&](double angle) {
      return is_usable(Motion{start, start * turned(angle * degree, axis)}) &&
             is_usable(Motion{start * turned(angle * degree, axis), start});
    };
    EXPECT_TRUE(usable(0));
    EXPECT_TRUE(usable(90));
    EXPECT_TRUE(usable(179.9));
    EXPECT_FALSE(usable(179.99));
    EXPECT_FALSE(usable(180));
    EXPECT_TRUE(usable(180.2));  // 179.8 the other way
  }
  EXPECT_FALSE(is_usable(Motion{Pose::Identity(), Pose(Eigen::Vector3d(-1, -1, 1).asDiagonal())}));
}

TEST(UsableMotions, AreFiniteAndRigid) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const bool at_start : {false, true}) {
    const auto usable = [&](auto&& spoil) {
      Motion motion;
      spoil(at_start ? motion.start : motion.end);
      return is_usable(motion);
    };
    EXPECT_TRUE(usable([](Pose& p) { p.translation().x() = 1e150; }));
    EXPECT_TRUE(usable([](Pose& p) { p.linear() *= 1 + 2e-10; }));
    for (const double bad : {nan, infinity, -infinity, 1e151}) {
      EXPECT_FALSE(usable([&](Pose& p) { p.translation().y() = bad; })) << bad;
      EXPECT_FALSE(usable([&](Pose& p) { p.linear()(1, 2) = bad; })) << bad;
    }
    EXPECT_FALSE(usable([](Pose& p) { p.linear() *= 1 + 1e-9; }));
    EXPECT_FALSE(usable([](Pose& p) { p.linear()(0, 1) = 1e-8; }));
  }
}

}  // namespace
}  // namespace encage::test
