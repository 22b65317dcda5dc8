// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mass_properties.h>

#include <Eigen/Geometry>

namespace encage::tank {

/// Where a body is and how it moves, in world units and seconds.
struct BodyState {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();      ///< principal frame -> world
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();            ///< of mass
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();          ///< of the centre
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();  ///< about the centre, world axes
};

/// The state of a body at rest whose mesh is turned by `orientation`, its centre at `centre`.
BodyState body_at_rest(const MassProperties& mass, const Eigen::Matrix3d& orientation, const Eigen::Vector3d& centre);

/// Frame of the mesh -> world. Within 1e-14 of rigid if the rotation is.
Eigen::Isometry3d pose(const MassProperties& mass, const BodyState& state);

/// The rotation nearest to a matrix that is one up to small errors e; what is left is of order e^2.
Eigen::Matrix3d orthonormalised(const Eigen::Matrix3d& rotation);

/// One step of free flight. The centre follows its parabola exactly. The rotation is the product of five turns about
/// principal axes (symmetric splitting; Hairer, Lubich and Wanner, "Geometric numerical integration", section VII.5),
/// each by a Cayley transform: second order, time-reversible, no drift of the energy; the angular momentum does not
/// change.
BodyState free_flight(const MassProperties& mass, const BodyState& state, const Eigen::Vector3d& gravity, double dt);

Eigen::Vector3d angular_velocity(const MassProperties& mass, const BodyState& state);

double kinetic_energy(const MassProperties& mass, const BodyState& state);

/// Velocity of the material point at `point` (world).
Eigen::Vector3d velocity_at(const MassProperties& mass, const BodyState& state, const Eigen::Vector3d& point);

/// Velocity along `direction` that a unit impulse along it at `point` (world) gives the material point there.
double mobility(const MassProperties& mass, const BodyState& state, const Eigen::Vector3d& point,
                const Eigen::Vector3d& direction);

void apply_impulse(const MassProperties& mass, BodyState& state, const Eigen::Vector3d& point,
                   const Eigen::Vector3d& impulse);

}  // namespace encage::tank
