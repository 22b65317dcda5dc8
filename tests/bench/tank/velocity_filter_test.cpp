// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/velocity_filter.h"

#include "bench/tank/scene.h"
#include "oracles/meshes.h"
#include "tests/bench/tank/ball_detector.h"

#include <gtest/gtest.h>

namespace encage::tank {
namespace {

constexpr double gravity = 9.81;

MassProperties ball() { return mass_properties(shapes::sphere(3)); }

BodyState at(const MassProperties& mass, const Eigen::Vector3d& centre, const Eigen::Vector3d& velocity) {
  BodyState body = body_at_rest(mass, Eigen::Matrix3d::Identity(), centre);
  body.velocity = velocity;
  return body;
}

FilterOptions weightless(double restitution = FilterOptions().restitution) {
  FilterOptions options;
  options.gravity.setZero();
  options.restitution = restitution;
  return options;
}

double closest(const std::vector<BodyState>& bodies) {
  double least = 1e9;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) least = std::min(least, (bodies[i].centre - bodies[j].centre).norm());
  }
  return least;
}

double energy(const MassProperties& mass, const std::vector<BodyState>& bodies) {
  double sum = 0;
  for (const BodyState& b : bodies) sum += kinetic_energy(mass, b) + mass.mass * gravity * b.centre.z();
  return sum;
}

TEST(VelocityFilter, HeadOnCollisionExchangesMomentum) {
  const MassProperties mass = ball();
  const BallDetector detector(1);
  VelocityFilter filter(detector, mass, {}, weightless(1));
  std::vector<BodyState> bodies = {at(mass, {-1.01, 0, 0}, {3, 0, 0}), at(mass, {1.01, 0, 0}, {-1, 0, 0})};
  FilterReport report;
  for (int i = 0; i < 50; ++i) {
    filter.step(bodies, report);
    EXPECT_GE(closest(bodies), 2);
  }
  EXPECT_EQ(report.conflicts, 1);
  EXPECT_EQ(report.held, 0);
  EXPECT_EQ(report.passes, 51);
  EXPECT_LT((bodies[0].velocity - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((bodies[1].velocity - Eigen::Vector3d(3, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(report.energy_lost, 0, 1e-12);
}

TEST(VelocityFilter, RestitutionTakesItsShareOfTheEnergy) {
  const MassProperties mass = ball();
  const BallDetector detector(1);
  VelocityFilter filter(detector, mass, {}, weightless(0.5));
  std::vector<BodyState> bodies = {at(mass, {-1.01, 0, 0}, {2, 0, 0}), at(mass, {1.01, 0, 0}, {-2, 0, 0})};
  FilterReport report;
  for (int i = 0; i < 50; ++i) filter.step(bodies, report);
  EXPECT_NEAR(bodies[0].velocity.x(), -1, 1e-12);
  EXPECT_NEAR(report.energy_lost, 4 * mass.mass * 0.75, 1e-12);  // of m v^2, as 1 - e^2
}

TEST(VelocityFilter, ImpulseRunsThroughARow) {
  // Newton's cradle: the momentum goes to the far end, through bodies that nearly touch.
  const MassProperties mass = ball();
  const BallDetector detector(1);
  VelocityFilter filter(detector, mass, {}, weightless(1));
  std::vector<BodyState> bodies;
  for (int i = 0; i < 5; ++i) bodies.push_back(at(mass, {2.0001 * i, 0, 0}, {0, 0, 0}));
  bodies.push_back(at(mass, {-2.3, 0, 0}, {2, 0, 0}));
  FilterReport report;
  for (int i = 0; i < 300; ++i) filter.step(bodies, report);
  EXPECT_NEAR(bodies[4].velocity.x(), 2, 1e-9);
  EXPECT_LT(bodies[5].velocity.norm(), 1e-9);
  EXPECT_EQ(report.held, 0);
}

TEST(VelocityFilter, BookkeepingOfEnergyAndMomentum) {
  const MassProperties mass = ball();
  const BallDetector detector(mass.radius);
  VelocityFilter filter(detector, mass, tank_walls(3), {});
  shapes::Random random(3);
  std::vector<BodyState> bodies;
  for (int i = 0; i < 8; ++i) {
    bodies.push_back(at(mass, {i % 2 ? 1.5 : -1.5, i / 2 % 2 ? 1.5 : -1.5, 2.0 + 3 * (i / 4)}, random.point(5)));
    bodies.back().angular_momentum = random.point(1);
  }
  const double before = energy(mass, bodies);
  FilterReport report;
  for (int i = 0; i < 4000; ++i) {
    filter.step(bodies, report);
    ASSERT_GE(closest(bodies), 2 * mass.radius);
    for (const BodyState& body : bodies) {
      ASSERT_GE(body.centre.z(), mass.radius);
      ASSERT_LE(body.centre.head<2>().cwiseAbs().maxCoeff(), 3 - mass.radius);
    }
  }
  EXPECT_GT(report.conflicts, 100);
  EXPECT_GT(report.energy_lost, 0.01 * before);
  EXPECT_NEAR(energy(mass, bodies), before - report.energy_lost, 1e-9 * before);
}

TEST(VelocityFilter, WithoutWallsNorGravityMomentumIsConserved) {
  const MassProperties mass = ball();
  const BallDetector detector(1);
  VelocityFilter filter(detector, mass, {}, weightless());
  shapes::Random random(8);
  std::vector<BodyState> bodies;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d place(i & 1 ? 2 : -2, i & 2 ? 2 : -2, i & 4 ? 2 : -2);
    bodies.push_back(at(mass, place, -place + random.point(0.3)));
    momentum += bodies.back().velocity;
  }
  FilterReport report;
  for (int i = 0; i < 2000; ++i) filter.step(bodies, report);
  EXPECT_GE(report.conflicts, 4);
  for (const BodyState& body : bodies) momentum -= body.velocity;
  EXPECT_LT(momentum.norm(), 1e-12);
}

/// Reports a contact whenever one of the bodies moves at all, with a normal that no impulse can satisfy.
class Jam : public BallDetector {
 public:
  Jam() : BallDetector(1) {}
  std::optional<Contact> pair(const Motion& a, const Motion& b, const ContactOptions&) const override {
    if (a.at_rest() && b.at_rest()) return {};
    Contact contact;
    contact.point = (a.start.translation() + b.start.translation()) / 2;
    contact.normal = Eigen::Vector3d::UnitY();
    return contact;
  }
};

TEST(VelocityFilter, HoldsWhatItCannotSolveAndThoseThatRunIntoIt) {
  const MassProperties mass = ball();
  const Jam detector;
  VelocityFilter filter(detector, mass, {}, weightless());
  // A row whose boxes overlap one by one, and one body far away.
  std::vector<BodyState> bodies;
  for (int i = 0; i < 4; ++i) bodies.push_back(at(mass, {1.9 * i, 0, 0}, {0.1, 0, 0}));
  bodies.push_back(at(mass, {100, 0, 0}, {0.1, 0, 0}));
  const std::vector<BodyState> before = bodies;
  FilterReport report;
  std::vector<Motion> trials;
  filter.step(bodies, report, &trials);
  EXPECT_EQ(report.held, 4);
  EXPECT_EQ(report.passes, 1 + FilterOptions().most_passes);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(bodies[i].centre, before[i].centre);
    EXPECT_EQ(bodies[i].rotation, before[i].rotation);
    EXPECT_EQ(bodies[i].velocity, before[i].velocity);
    EXPECT_FALSE(trials[i].at_rest()) << "the first trial is recorded, not what became of it";
  }
  EXPECT_GT(bodies[4].centre.x(), 100);
  // They stay for good, and the step ends every time.
  filter.step(bodies, report);
  EXPECT_EQ(report.held, 8);
}

TEST(VelocityFilter, HoldsABodyThatWouldTurnMoreThanDetectionCanFollow) {
  const MassProperties mass = ball();
  const BallDetector detector(1);
  FilterOptions options;
  options.dt = 0.1;
  VelocityFilter filter(detector, mass, {}, options);
  std::vector<BodyState> bodies = {at(mass, {0, 0, 0}, {1, 0, 0})};
  bodies[0].angular_momentum = 1e9 * bodies[0].rotation.col(2);
  FilterReport report;
  filter.step(bodies, report);
  EXPECT_EQ(report.held, 1);
  EXPECT_EQ(bodies[0].centre, Eigen::Vector3d::Zero());
}

TEST(VelocityFilter, CollisionsCanBeSwitchedOff) {
  const MassProperties mass = ball();
  const BallDetector detector(1);
  FilterOptions options;
  options.collisions = false;
  VelocityFilter filter(detector, mass, tank_walls(3), options);
  std::vector<BodyState> bodies = {at(mass, {-1.5, 0, 1.5}, {3, 0, 0}), at(mass, {1.5, 0, 1.5}, {-3, 0, 0})};
  FilterReport report;
  for (int i = 0; i < 480; ++i) filter.step(bodies, report);
  EXPECT_LT(closest(bodies), 1);
  EXPECT_EQ(report.pair_tests, 0);
  EXPECT_GT(report.wall_tests, 0);
}

}  // namespace
}  // namespace encage::tank
