// SPDX-License-Identifier: GPL-3.0-or-later
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

/// True position of a point of the body frame: `pivot` moves on its straight path, and the body turns at uniform
/// angular velocity.
Point on_arc(const Motion& motion, const Vector& pivot, const Point& x, Real t) {
  using Rotation = Eigen::AngleAxis<Real>;
  const Rotation turn(
      Eigen::Matrix<Real, 3, 3>((motion.end.linear() * motion.start.linear().transpose()).cast<Real>()));
  const auto position = [&](const Pose& pose) -> Point { return (pose * pivot).cast<Real>(); };
  const Point centre = (1 - t) * position(motion.start) + t * position(motion.end);
  const Point arm = motion.start.linear().cast<Real>() * (x - pivot.cast<Real>());
  return centre + Rotation(turn.angle() * t, turn.axis()) * arm;
}

Point on_line(const Motion& motion, const Point& x, Real t) {
  const auto position = [&](const Pose& pose) -> Point {
    return pose.linear().cast<Real>() * x + pose.translation().cast<Real>();
  };
  return (1 - t) * position(motion.start) + t * position(motion.end);
}

TEST(ArcMargin, IsInfiniteWhereNoRotationLeads) {
  const Body box(sample_shapes(0)[1]);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Motion motion;
  motion.end.linear() = turned(1, Vector::UnitX()).linear();
  EXPECT_LT(arc_margin(*box.shape, motion), 1);
  for (Pose* pose : {&motion.start, &motion.end}) {
    const Pose before = *pose;
    pose->linear().col(1) *= -1;
    EXPECT_EQ(arc_margin(*box.shape, motion), std::numeric_limits<double>::infinity());
    *pose = before;
    pose->linear()(2, 0) = nan;
    EXPECT_EQ(arc_margin(*box.shape, motion), std::numeric_limits<double>::infinity());
    *pose = before;
    pose->linear() *= 1.5;
    EXPECT_EQ(arc_margin(*box.shape, motion), std::numeric_limits<double>::infinity());
    *pose = before;
  }
  EXPECT_EQ(arc_margin(*box.shape, Motion{.start = turned(1, Vector::UnitX()), .end = turned(1, Vector::UnitX())}), 0);
}

TEST(ArcMargin, BoundsTheDepartureFromStraightPaths) {
  shapes::Random random(2);
  std::vector<Body> all;
  for (Sample sample : sample_shapes(0)) {
    all.emplace_back(sample);
    sample.hierarchy.origin = Vector(20, -3, 0.5);
    all.emplace_back(without_cages(scaled(sample, -4)));
  }
  for (int round = 0; round < 400; ++round) {
    SCOPED_TRACE(round);
    const Body& body = all[random.integer(static_cast<int>(all.size()))];
    const Vector& origin = body.origin();
    const Vector pivot = random.integer(3) == 0   ? Vector(random.point(2))
                         : random.integer(2) == 0 ? Vector::Zero()
                                                  : origin;
    const double angle = std::vector{1e-6, 0.01, 0.5, 2.0, 3.1, 179 * degree}[random.integer(6)];
    Motion motion;
    motion.start = random_pose(random, 5);
    motion.end.linear() = turned(angle, random_direction(random)).linear() * motion.start.linear();
    motion.end.translation() = motion.start.translation() + random.point(1);
    const double arc = arc_margin(*body.shape, motion, pivot);
    for (std::int64_t v = 0; v < body.mesh().vertices.rows(); ++v) {
      const Point x = (origin + body.mesh().vertex(static_cast<std::int32_t>(v))).cast<Real>();
      for (int s = 0; s <= 32; ++s) {
        const Real t = Real(s) / 32;
        const Real off = (on_arc(motion, pivot, x, t) - on_line(motion, x, t)).norm();
        // The poses are rigid up to 1e-15 only.
        ASSERT_LE(off, static_cast<Real>(arc) * 4 * t * (1 - t) * (1 + 1e-9L) + 1e-13L) << v << " " << s;
      }
    }
  }
}

TEST(ArcMargin, IsTightForAVertexFarthestFromTheAxis) {
  const Body box(without_cages(sample_shapes(0)[1]));  // its farthest vertices are at sqrt(3)
  for (const double angle : {0.001, 0.1, 1.0, 3.0, 179 * degree}) {
    const Motion motion{Pose::Identity(), turned(angle, Vector(1, -1, 0))};  // (1, 1, 1) is orthogonal to the axis
    const double true_bulge = std::sqrt(3.0) * (1 - std::cos(angle / 2));
    EXPECT_GE(arc_margin(*box.shape, motion), true_bulge * (1 - 1e-9));
    EXPECT_LE(arc_margin(*box.shape, motion), true_bulge * (1 + 1e-7)) << angle;
    EXPECT_NEAR(arc_margin(*box.shape, motion, Vector(2, 0, 0)), true_bulge / std::sqrt(3.0) * (std::sqrt(3.0) + 2),
                1e-6);
  }
}

TEST(ArcMargin, IsZeroWithoutRotation) {
  shapes::Random random(3);
  const Body box(sample_shapes(0)[1]);
  for (int i = 0; i < 50; ++i) {
    Motion motion = Motion::resting(random_pose(random, 3));
    EXPECT_EQ(arc_margin(*box.shape, motion), 0);
    motion.end.translation() += random.point(1);
    EXPECT_EQ(arc_margin(*box.shape, motion), 0);
    EXPECT_EQ(arc_margin(*box.shape, motion, random.point(5)), 0);
  }
}

}  // namespace
}  // namespace encage::test
