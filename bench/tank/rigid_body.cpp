// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/rigid_body.h"

#include <array>

namespace encage::tank {
namespace {

struct Turn {
  int axis;
  double share;  // of the time step
};
constexpr std::array<Turn, 5> splitting = {{{0, 0.5}, {1, 0.5}, {2, 1}, {1, 0.5}, {0, 0.5}}};

/// Turns the frame about its own axis by about `angle`: Cayley's transform of it, a rotation for every angle.
void turn(Eigen::Matrix3d& rotation, int axis, double angle) {
  const double half = angle / 2;
  const double scale = 1 / (1 + half * half);
  const double cosine = (1 - half * half) * scale, sine = 2 * half * scale;
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const Eigen::Vector3d u = rotation.col(i), w = rotation.col(j);
  rotation.col(i) = cosine * u + sine * w;
  rotation.col(j) = cosine * w - sine * u;
}

/// R I^-1 R^T x.
Eigen::Vector3d over_inertia(const MassProperties& mass, const BodyState& state, const Eigen::Vector3d& x) {
  const Eigen::Vector3d local = state.rotation.transpose() * x;
  return state.rotation * local.cwiseQuotient(mass.moments);
}

}  // namespace

BodyState body_at_rest(const MassProperties& mass, const Eigen::Matrix3d& orientation, const Eigen::Vector3d& centre) {
  BodyState state;
  state.rotation = orthonormalised(orientation * mass.axes);
  state.centre = centre;
  return state;
}

Eigen::Isometry3d pose(const MassProperties& mass, const BodyState& state) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  frame.linear() = orthonormalised(state.rotation * mass.axes.transpose());
  frame.translation() = state.centre - frame.linear() * mass.centre;
  return frame;
}

Eigen::Matrix3d orthonormalised(const Eigen::Matrix3d& rotation) {
  // One step of Newton's method for the orthogonal polar factor, without the inverse.
  const Eigen::Matrix3d gram = rotation.transpose() * rotation;
  return rotation * (1.5 * Eigen::Matrix3d::Identity() - 0.5 * gram);
}

BodyState free_flight(const MassProperties& mass, const BodyState& state, const Eigen::Vector3d& gravity, double dt) {
  BodyState next = state;
  next.centre += dt * state.velocity + dt * dt / 2 * gravity;
  next.velocity += dt * gravity;
  for (const Turn& t : splitting) {
    const double momentum = next.rotation.col(t.axis).dot(state.angular_momentum);
    turn(next.rotation, t.axis, t.share * dt * momentum / mass.moments[t.axis]);
  }
  next.rotation = orthonormalised(next.rotation);
  return next;
}

Eigen::Vector3d angular_velocity(const MassProperties& mass, const BodyState& state) {
  return over_inertia(mass, state, state.angular_momentum);
}

double kinetic_energy(const MassProperties& mass, const BodyState& state) {
  const Eigen::Vector3d local = state.rotation.transpose() * state.angular_momentum;
  return (mass.mass * state.velocity.squaredNorm() + local.dot(local.cwiseQuotient(mass.moments))) / 2;
}

Eigen::Vector3d velocity_at(const MassProperties& mass, const BodyState& state, const Eigen::Vector3d& point) {
  return state.velocity + angular_velocity(mass, state).cross(point - state.centre);
}

double mobility(const MassProperties& mass, const BodyState& state, const Eigen::Vector3d& point,
                const Eigen::Vector3d& direction) {
  const Eigen::Vector3d moment = (point - state.centre).cross(direction);
  return direction.squaredNorm() / mass.mass + moment.dot(over_inertia(mass, state, moment));
}

void apply_impulse(const MassProperties& mass, BodyState& state, const Eigen::Vector3d& point,
                   const Eigen::Vector3d& impulse) {
  state.velocity += impulse / mass.mass;
  state.angular_momentum += (point - state.centre).cross(impulse);
}

}  // namespace encage::tank
