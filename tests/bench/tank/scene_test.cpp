// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/scene.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace encage::tank {
namespace {

MassProperties body() { return mass_properties(shapes::box({0, 0, 0}, {0.5, 1, 1.5})); }

TEST(Scene, NamesGoBothWays) {
  for (const TankScene scene : {TankScene::drop, TankScene::bouncing, TankScene::resting})
    EXPECT_EQ(scene_named(name(scene)), scene);
  EXPECT_THROW(scene_named("swim"), Error);
}

TEST(Scene, RefusesNonsenseByName) {
  const MassProperties mass = body();
  EXPECT_NO_THROW(validate({}, mass));
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                          infinity = std::numeric_limits<double>::infinity();
  struct Case {
    const char* option;
    std::function<void(TankOptions&)> change;
  };
  const std::vector<Case> cases = {
      {"bodies", [](TankOptions& o) { o.bodies = 0; }},
      {"bodies", [](TankOptions& o) { o.bodies = 10'001; }},
      {"dt", [](TankOptions& o) { o.dt = 0; }},
      {"dt", [](TankOptions& o) { o.dt = nan; }},
      {"dt", [](TankOptions& o) { o.dt = 0.2; }},
      {"seconds", [](TankOptions& o) { o.seconds = 0; }},
      {"seconds", [](TankOptions& o) { o.seconds = infinity; }},
      {"seconds", [](TankOptions& o) { o.dt = 1e-4, o.seconds = 1e4; }},
      {"drop interval", [](TankOptions& o) { o.drop_interval = -1; }},
      {"drop interval", [](TankOptions& o) { o.drop_interval = nan; }},
      {"restitution", [](TankOptions& o) { o.restitution = 1.01; }},
      {"restitution", [](TankOptions& o) { o.restitution = -0.1; }},
      {"gravity", [](TankOptions& o) { o.gravity = -1; }},
      {"gravity", [](TankOptions& o) { o.gravity = infinity; }},
      {"floor height", [](TankOptions& o) { o.floor_height = nan; }},
      {"rest height", [](TankOptions& o) { o.rest_height = -1; }},
      {"half width", [](TankOptions& o) { o.half_width = 0.5; }},
      {"half width", [](TankOptions& o) { o.half_width = nan; }},
  };
  for (const Case& c : cases) {
    TankOptions options;
    c.change(options);
    try {
      validate(options, mass);
      ADD_FAILURE() << c.option;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(c.option), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(validate({}, MassProperties{}), Error);
}

TEST(Scene, BodiesEnterAboveTheOthersAndInsideTheWalls) {
  const MassProperties mass = body();
  TankOptions options;
  options.half_width = 1.5 * mass.radius;
  Entries entries(options, mass);
  double mean = 0;
  for (int i = 0; i < 200; ++i) {
    const double top = i % 2 ? 10.0 : 0.0;
    const BodyState state = entries.next(top);
    EXPECT_LE(state.centre.head<2>().cwiseAbs().maxCoeff() + mass.radius, *options.half_width);
    EXPECT_GE(state.centre.z() - mass.radius, top + 0.09 * mass.radius);
    EXPECT_GE(state.centre.z(), 3 * mass.radius);
    EXPECT_EQ(state.velocity, Eigen::Vector3d::Zero());
    EXPECT_EQ(state.angular_momentum, Eigen::Vector3d::Zero());
    EXPECT_LT((state.rotation.transpose() * state.rotation - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_GT(state.rotation.determinant(), 0);
    mean += state.rotation(2, 2) / 200;
  }
  EXPECT_NEAR(mean, 0, 0.15) << "orientations are uniform";
}

TEST(Scene, EntriesDependOnTheSeedAlone) {
  const MassProperties mass = body();
  TankOptions options;
  Entries once(options, mass), again(options, mass);
  options.seed = 2;
  Entries other(options, mass);
  for (int i = 0; i < 5; ++i) {
    const BodyState a = once.next(0), b = again.next(0), c = other.next(0);
    EXPECT_EQ(a.rotation, b.rotation);
    EXPECT_EQ(a.centre, b.centre);
    EXPECT_NE(a.rotation, c.rotation);
  }
}

TEST(Scene, ADropEveryInterval) {
  const MassProperties mass = body();
  Entries entries({}, mass);
  EXPECT_EQ(entries.entry_step(0), 0);
  EXPECT_EQ(entries.entry_step(1), 576);
  EXPECT_EQ(entries.entry_step(17), 17 * 576);
}

TEST(Scene, WallsLookInwards) {
  const std::vector<HalfSpace> walls = tank_walls(2);
  ASSERT_EQ(walls.size(), 5U);
  for (const HalfSpace& wall : walls) {
    EXPECT_GT(wall.normal.dot(Eigen::Vector3d(0.5, -0.5, 100)), wall.offset);
    EXPECT_EQ(wall.normal.norm(), 1);
  }
  for (const Eigen::Vector3d& outside :
       {Eigen::Vector3d(2.1, 0, 1), {-2.1, 0, 1}, {0, 2.1, 1}, {0, -2.1, 1}, {0, 0, -0.1}}) {
    int beyond = 0;
    for (const HalfSpace& wall : walls) beyond += wall.normal.dot(outside) <= wall.offset;
    EXPECT_EQ(beyond, 1);
  }
}

TEST(Scene, OnlyBouncingFeedsAndOnlyRestingDrains) {
  const MassProperties mass = body();
  TankOptions options;
  const double floor = mass.mass * options.gravity * options.floor_height * mass.radius;
  EXPECT_EQ(velocity_factor(options, mass, 0.1 * floor, 9), 1);
  options.scene = TankScene::bouncing;
  EXPECT_GT(velocity_factor(options, mass, 0.1 * floor, 9), 1);
  EXPECT_LT(velocity_factor(options, mass, 0.1 * floor, 9), 1.01);
  EXPECT_EQ(velocity_factor(options, mass, 1.1 * floor, 9), 1);
  EXPECT_EQ(velocity_factor(options, mass, 0, 9), 1);
  options.scene = TankScene::resting;
  EXPECT_LT(velocity_factor(options, mass, floor, 9), 1);
  EXPECT_GT(velocity_factor(options, mass, floor, 9), 0.9);
  EXPECT_GT(velocity_factor(options, mass, floor, 0.1), velocity_factor(options, mass, floor, 1)) << "smoothly";
  EXPECT_GT(velocity_factor(options, mass, 0.5 * options.rest_height / options.floor_height * floor, 9), 1);
}

}  // namespace
}  // namespace encage::tank
