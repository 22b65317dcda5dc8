// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/rigid_body.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace encage::tank {
namespace {

const Eigen::Vector3d none = Eigen::Vector3d::Zero();

MassProperties brick() { return mass_properties(shapes::box({-0.5, -1, -1.5}, {0.5, 1, 1.5})); }

BodyState tumbling(const MassProperties& mass) {
  BodyState state = body_at_rest(mass, Eigen::Matrix3d::Identity(), {1, 2, 3});
  state.velocity = {0.3, -0.2, 0.1};
  // Near the middle axis, where free bodies turn over.
  state.angular_momentum = state.rotation * Eigen::Vector3d(0.05, 8, 0.03);
  return state;
}

double departure(const Eigen::Matrix3d& r) {
  return (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

TEST(RigidBody, FallsFreelyOnTheParabola) {
  const MassProperties mass = brick();
  const Eigen::Vector3d gravity(0, 0, -9.81);
  BodyState state = tumbling(mass);
  const BodyState start = state;
  const double dt = 1.0 / 960;
  for (int i = 0; i < 960; ++i) state = free_flight(mass, state, gravity, dt);
  EXPECT_LT((state.centre - (start.centre + start.velocity + gravity / 2)).norm(), 1e-12);
  EXPECT_LT((state.velocity - (start.velocity + gravity)).norm(), 1e-12);
}

TEST(RigidBody, TumblesWithoutDriftOfEnergyOrMomentum) {
  const MassProperties mass = brick();
  BodyState state = tumbling(mass);
  const BodyState start = state;
  const double energy = kinetic_energy(mass, state);
  double worst = 0, turned_over = 1;
  for (int i = 0; i < 200'000; ++i) {
    state = free_flight(mass, state, none, 1.0 / 960);
    worst = std::max(worst, std::abs(kinetic_energy(mass, state) - energy));
    turned_over = std::min(turned_over, state.rotation.col(1).dot(start.rotation.col(1)));
  }
  EXPECT_LT(turned_over, -0.9) << "the middle axis is unstable";
  EXPECT_LT(worst, 1e-5 * energy);
  // At the end as well as in between: no drift.
  EXPECT_EQ(state.angular_momentum, start.angular_momentum);
  EXPECT_LT(departure(state.rotation), 1e-15);
  EXPECT_LT(departure(pose(mass, state).linear()), 1e-15);
}

TEST(RigidBody, SpinsAboutAPrincipalAxisAtItsSpeed) {
  const MassProperties mass = brick();
  for (int axis = 0; axis < 3; ++axis) {
    BodyState state = body_at_rest(mass, Eigen::Matrix3d::Identity(), none);
    const Eigen::Vector3d along = state.rotation.col(axis);
    state.angular_momentum = 2 * mass.moments[axis] * along;  // 2 radians a second
    EXPECT_LT((angular_velocity(mass, state) - 2 * along).norm(), 1e-14);
    for (int i = 0; i < 1000; ++i) state = free_flight(mass, state, none, 1e-3);
    const Eigen::Matrix3d expected = Eigen::AngleAxisd(2, along).toRotationMatrix() * mass.axes;
    EXPECT_LT((state.rotation - expected).norm(), 2e-6);
  }
}

TEST(RigidBody, IsOfSecondOrder) {
  const MassProperties mass = brick();
  const auto after_a_second = [&](int steps) {
    BodyState state = tumbling(mass);
    for (int i = 0; i < steps; ++i) state = free_flight(mass, state, none, 1.0 / steps);
    return state.rotation;
  };
  const Eigen::Matrix3d exact = after_a_second(12'800);
  const double coarse = (after_a_second(200) - exact).norm(), fine = (after_a_second(400) - exact).norm();
  EXPECT_GT(coarse, 1e-7);
  EXPECT_NEAR(coarse / fine, 4, 0.1);
}

TEST(RigidBody, FliesBackwardsTheSameWay) {
  const MassProperties mass = brick();
  const BodyState start = tumbling(mass);
  BodyState state = start;
  for (int i = 0; i < 500; ++i) state = free_flight(mass, state, none, 0.01);
  EXPECT_GT((state.rotation - start.rotation).norm(), 0.1);
  state.velocity *= -1;
  state.angular_momentum *= -1;
  for (int i = 0; i < 500; ++i) state = free_flight(mass, state, none, 0.01);
  EXPECT_LT((state.rotation - start.rotation).norm(), 1e-11);
  EXPECT_LT((state.centre - start.centre).norm(), 1e-12);
}

TEST(RigidBody, PoseTakesTheMeshAlong) {
  const MassProperties mass = mass_properties(shapes::box({1, 2, 3}, {2, 4, 6}));
  BodyState state = body_at_rest(mass, Eigen::Matrix3d::Identity(), mass.centre);
  EXPECT_LT((pose(mass, state).matrix() - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 1e-14);
  state.angular_momentum = {0.1, 0.2, 0.3};
  state.velocity = {1, 0, 0};
  // The velocity of a material point is what its place changes by.
  const double dt = 1e-6;
  const Eigen::Vector3d corner(2, 4, 6);
  const Eigen::Vector3d before = pose(mass, state) * corner;
  const Eigen::Vector3d after = pose(mass, free_flight(mass, state, none, dt)) * corner;
  EXPECT_LT(((after - before) / dt - velocity_at(mass, state, before)).norm(), 1e-6);
}

TEST(RigidBody, ImpulseChangesVelocityByTheMobilityAndEnergyByItsWork) {
  const MassProperties mass = brick();
  BodyState state = tumbling(mass);
  const Eigen::Vector3d point(1.5, 3, 4.5);
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 2, -2) / 3;
  const double before = velocity_at(mass, state, point).dot(direction), energy = kinetic_energy(mass, state);
  const double impulse = 0.7, k = mobility(mass, state, point, direction);
  const Eigen::Vector3d momentum = mass.mass * state.velocity;
  apply_impulse(mass, state, point, impulse * direction);
  EXPECT_NEAR(velocity_at(mass, state, point).dot(direction), before + k * impulse, 1e-14);
  EXPECT_NEAR(kinetic_energy(mass, state), energy + impulse * before + k * impulse * impulse / 2, 1e-13);
  EXPECT_LT((mass.mass * state.velocity - momentum - impulse * direction).norm(), 1e-14);
}

TEST(RigidBody, OrthonormalisationIsQuadratic) {
  Eigen::Matrix3d r = Eigen::AngleAxisd(1, Eigen::Vector3d(1, 2, 2) / 3).toRotationMatrix();
  const Eigen::Matrix3d exact = r;
  r(0, 1) += 1e-6;
  r(2, 2) -= 1e-6;
  EXPECT_GT(departure(r), 1e-7);
  EXPECT_LT(departure(orthonormalised(r)), 1e-11);
  EXPECT_LT((orthonormalised(r) - exact).norm(), 2e-6);
}

}  // namespace
}  // namespace encage::tank
