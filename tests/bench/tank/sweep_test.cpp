// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/sweep.h"

#include "tests/bench/tank/swept_meshes.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace encage::tank {
namespace {

TEST(Sweep, VerticesStartAndEndWhereThePosesSay) {
  const Eigen::Vector3d origin(3, 0, -1);
  const BodyMesh body(test::soup(5, 0.1, 1), origin);
  std::mt19937 random(1);
  const Motion motion = test::random_motion(random, 2, 0.1);
  const Sweep sweep = make_sweep(body, motion, 0);
  for (std::int32_t v = 0; v < 15; ++v) {
    EXPECT_LT((sweep.start_of(v) - motion.start * (origin + body.mesh.vertex(v))).norm(), 1e-14);
    EXPECT_LT((sweep.end_of(v) - motion.end * (origin + body.mesh.vertex(v))).norm(), 1e-14);
  }
}

TEST(BodyMesh, SlackIsHalfTheDistanceAndRounding) {
  const BodyMesh body(test::soup(5, 0.1, 1), Eigen::Vector3d::Zero());
  EXPECT_GE(body.radius, body.mesh.vertices.rowwise().norm().maxCoeff());
  EXPECT_GT(body.slack({}, 0), 0);
  EXPECT_LT(body.slack({}, 0), 1e-11);
  EXPECT_NEAR(body.slack({}, 0.5), 0.25, 1e-11);
  Motion far;
  far.end.translation().x() = 1e6;
  EXPECT_GT(body.slack(far, 0), 1e5 * body.slack({}, 0));
}

TEST(FloatAbove, IsNotBelowAndClose) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-10, 10);
  for (int i = 0; i < 10000; ++i) {
    const double x = unit(random);
    EXPECT_GE(static_cast<double>(float_above(x)), x);
    EXPECT_LE(static_cast<double>(float_above(x)), x + 3e-7 * std::abs(x));
  }
  for (const double x : {0.0, 1e-300, -1e-300, 1e-40, -1e-40, 1.0, -1.0}) {
    EXPECT_GE(static_cast<double>(float_above(x)), x) << x;
    EXPECT_LE(static_cast<double>(float_above(x)), x + 1e-6) << x;
  }
}

}  // namespace
}  // namespace encage::tank
