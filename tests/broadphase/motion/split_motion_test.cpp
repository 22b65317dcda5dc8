// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/sampled.h"

#include <encage/contact.h>
#include <encage/error.h>
#include <encage/split_motion.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

/// Exact position of a point of the body frame.
Point swept(const VelocityMotion& motion, const Point& x, Real time) {
  const Point pivot = Real(motion.scale) * motion.pivot.cast<Real>();
  const Eigen::Matrix<Real, 3, 3> start = motion.start.linear().cast<Real>();
  const Real speed = motion.angular_velocity.cast<Real>().norm();
  Point arm = start * (Real(motion.scale) * x - pivot);
  if (speed > 0) {
    arm = Eigen::AngleAxis<Real>(speed * time, Point(motion.angular_velocity.cast<Real>() / speed)) * arm;
  }
  return start * pivot + motion.start.translation().cast<Real>() + time * motion.velocity.cast<Real>() + arm;
}

Point on_line(const Motion& motion, const Point& x, Real t) {
  const auto at = [&](const Pose& pose) -> Point {
    return pose.linear().cast<Real>() * (Real(motion.scale) * x) + pose.translation().cast<Real>();
  };
  return (1 - t) * at(motion.start) + t * at(motion.end);
}

double angle(const Motion& motion) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(motion.end.linear() * motion.start.linear().transpose())).angle();
}

VelocityMotion random_course(shapes::Random& random) {
  VelocityMotion motion;
  motion.start = random_pose(random, 5);
  motion.velocity = random.point(3);
  const double turns = std::vector{0.0, 1e-6, 0.3, 0.5, 1.0, 7.3}[random.integer(6)];
  motion.duration = random.integer(2) == 0 ? 1 : 0.0123;
  motion.angular_velocity = random_direction(random) * (2 * std::acos(-1.0) * turns / motion.duration);
  motion.scale = random.integer(2) == 0 ? 1 : 2.5;
  if (random.integer(2) == 0) motion.pivot = random.point(2);
  return motion;
}

TEST(SplitMotions, StayWithinTheirArcMargins) {
  shapes::Random random(1);
  const std::vector<Body> bodies = sample_bodies();
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    const VelocityMotion course = random_course(random);
    const double largest = std::vector{1.5707963267948966, 3.1, 0.2}[random.integer(3)];
    const Body& body = bodies[random.integer(static_cast<int>(bodies.size()))];
    const std::vector<Motion> parts = split_motion(course, largest);
    const Real count = static_cast<Real>(parts.size());
    ASSERT_EQ(parts.front().start.matrix(), course.start.matrix());
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const Motion& part = parts[i];
      ASSERT_TRUE(is_usable(part));
      ASSERT_EQ(part.scale, course.scale);
      ASSERT_LE(angle(part), largest + 1e-9);
      if (i > 0) {
        ASSERT_EQ(part.start.matrix(), parts[i - 1].end.matrix());
      }
      if (i % 4 != 0) continue;
      const double arc = arc_margin(*body.shape, part, course.pivot);
      for (std::int64_t v = 0; v < body.mesh().vertices.rows(); v += 3) {
        const Point x = (body.origin() + body.mesh().vertex(static_cast<std::int32_t>(v))).cast<Real>();
        for (int s = 0; s <= 8; ++s) {
          const Real t = Real(s) / 8, time = (static_cast<Real>(i) + t) / count * Real(course.duration);
          const Real off = (swept(course, x, time) - on_line(part, x, t)).norm();
          // The poses are rounded, as the header says; sizes are below 30.
          ASSERT_LE(off, static_cast<Real>(arc) * 4 * t * (1 - t) * (1 + 1e-9L) + 1e-12L) << v << " " << s;
        }
      }
    }
  }
}

TEST(SplitMotions, HaveAsFewPartsAsAnglesAdmit) {
  const auto count = [](double radians, double largest) {
    return split_motion({.angular_velocity = Vector(0, radians, 0)}, largest).size();
  };
  EXPECT_EQ(count(0, 1), 1U);
  EXPECT_EQ(count(0.999, 1), 1U);
  EXPECT_EQ(count(1.001, 1), 2U);
  EXPECT_EQ(count(-6.3, 3.1), 3U);
  EXPECT_EQ(count(100, 0.01), 10'000U + 1U);  // rounded up
  const std::vector<Motion> straight = split_motion({.velocity = Vector(1, 2, 3), .duration = 2});
  EXPECT_EQ(straight.front().end.matrix(), shift(2, 4, 6).matrix());
  EXPECT_EQ(split_motion({.duration = 0}).front().at_rest(), true);
}

// A blade that turns by 190 degrees: two poses say -170, the other way.
TEST(SplitMotions, FindWhatTwoPosesMiss) {
  const ShapePtr blade = make_shape(shapes::box(Vector(0, -0.1, -0.1), Vector(5, 0.1, 0.1)));
  const ShapePtr post = make_shape(shapes::box(Vector(-0.1, 3.9, -1), Vector(0.1, 4.1, 1)));
  const Motion still = Motion::resting(Pose::Identity());
  const VelocityMotion course = {.angular_velocity = Vector(0, 0, 190 * std::acos(-1.0) / 180)};
  const std::vector<Motion> parts = split_motion(course, 1);
  const Motion ends = {course.start, parts.back().end};
  ASSERT_TRUE(is_usable(ends));
  EXPECT_TRUE(separated(*blade, ends, *post, still).separated);
  int hits = 0, misses = 0;
  for (const Motion& part : parts) {
    const double arc = arc_margin(*blade, part);
    const bool contact = first_contact(*blade, part, *post, still, {.arc = arc}).has_value();
    if (contact) {
      EXPECT_FALSE(separated(*blade, part, *post, still, arc).separated);
    }
    ++(contact ? hits : misses);
  }
  EXPECT_GE(hits, 1);
  EXPECT_GE(misses, 2);
}

TEST(SplitMotions, NameTheReasonOfARefusal) {
  constexpr double not_finite = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const std::function<void(VelocityMotion&)>& spoil, double largest = 1) -> std::string {
    VelocityMotion motion = {.angular_velocity = Vector(0, 0, 1)};
    spoil(motion);
    try {
      split_motion(motion, largest);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto nothing = [](VelocityMotion&) {};
  EXPECT_EQ(refused(nothing), "accepted");
  EXPECT_EQ(refused(nothing, 3.2), "split motion: the largest angle 3.2 is not between 0 and 3.1 radians");
  EXPECT_EQ(refused(nothing, 0), "split motion: the largest angle 0 is not between 0 and 3.1 radians");
  EXPECT_EQ(refused(nothing, not_finite), "split motion: the largest angle nan is not between 0 and 3.1 radians");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.start.linear()(0, 0) = -1; }),
            "split motion: the start pose mirrors the body");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.scale = 0; }), "split motion: the scale 0 is not between 1e-50 and 1e50");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.velocity.x() = not_finite; }),
            "split motion: the velocity is not finite");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.angular_velocity.x() = not_finite; }),
            "split motion: the angular velocity is not finite");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.duration = -1; }),
            "split motion: the duration -1 is negative or not finite");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.pivot.y() = not_finite; }),
            "split motion: the pivot is not finite or beyond 1e150");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.velocity.x() = 1e151; }),
            "split motion: part 1 of 2: the end pose is farther than 1e150 away");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.angular_velocity.x() = 2e6; }),
            "split motion: the body turns by 2000000 radians, in more than a million parts of 1");
  EXPECT_EQ(refused([](VelocityMotion& m) { m.angular_velocity.x() = 1e300; }),
            "split motion: the body turns by 1e+300 radians, in more than a million parts of 1");
}

}  // namespace
}  // namespace encage::test
