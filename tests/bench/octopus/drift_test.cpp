// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/drift.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace encage::octopus {
namespace {

TEST(Drift, GivesEveryBodyInEveryStep) {
  const auto steps = drifting_poses({.bodies = 5, .steps = 7});
  ASSERT_EQ(steps.size(), 7U);
  for (std::size_t s = 0; s < steps.size(); ++s) {
    EXPECT_EQ(steps[s].step, static_cast<std::int64_t>(s));
    ASSERT_EQ(steps[s].bodies.size(), 5U);
    for (std::size_t b = 0; b < 5; ++b) EXPECT_EQ(steps[s].bodies[b].body, static_cast<std::int32_t>(b));
  }
}

TEST(Drift, PosesAreRigid) {
  for (const PoseStep& step : drifting_poses({.bodies = 18, .steps = 20, .dt = 0.7})) {
    for (const BodyPose& body : step.bodies) {
      const Eigen::Matrix3d r = body.pose.linear();
      EXPECT_LT((r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
      EXPECT_GT(r.determinant(), 0);
    }
  }
}

TEST(Drift, IsTheSameTwice) {
  const Drift drift{.bodies = 6, .steps = 9};
  const auto once = drifting_poses(drift), again = drifting_poses(drift);
  for (std::size_t s = 0; s < once.size(); ++s) {
    for (std::size_t b = 0; b < once[s].bodies.size(); ++b) {
      EXPECT_EQ(once[s].bodies[b].pose.matrix(), again[s].bodies[b].pose.matrix());
    }
  }
}

TEST(Drift, MovesSmoothlyAndAllTheTime) {
  const Drift drift{.bodies = 18, .steps = 60};
  const auto steps = drifting_poses(drift);
  for (std::size_t s = 1; s < steps.size(); ++s) {
    for (std::size_t b = 0; b < 18; ++b) {
      const auto &before = steps[s - 1].bodies[b].pose, &after = steps[s].bodies[b].pose;
      // The farthest that a point on the unit sphere can move: the shift, and the turn of the frame.
      const double moved =
          (after.translation() - before.translation()).norm() + (after.linear() - before.linear()).norm();
      EXPECT_GT(moved, 0);
      EXPECT_LT(moved, 0.03);
    }
  }
}

TEST(Drift, BodiesStayInANarrowTankAndNearEachOther) {
  const auto steps = drifting_poses({.bodies = 18, .steps = 40, .dt = 0.1});
  for (const PoseStep& step : steps) {
    for (std::size_t b = 0; b < step.bodies.size(); ++b) {
      const Eigen::Vector3d p = step.bodies[b].pose.translation();
      EXPECT_LT(p.head<2>().norm(), 1.0);
      if (b > 0) {
        EXPECT_LT((p - step.bodies[b - 1].pose.translation()).norm(), 2.0) << "circumscribed spheres overlap";
      }
    }
  }
}

TEST(Drift, RefusesNonsense) {
  EXPECT_THROW(drifting_poses({.bodies = 0}), Error);
  EXPECT_THROW(drifting_poses({.steps = 0}), Error);
  EXPECT_THROW(drifting_poses({.dt = 0}), Error);
  EXPECT_THROW(drifting_poses({.dt = -1}), Error);
}

}  // namespace
}  // namespace encage::octopus
