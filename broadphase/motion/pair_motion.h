// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

#include <array>

namespace encage {

/// x -> linear x + offset.
struct AffineMap {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator()(const Eigen::Vector3d& x) const { return linear * x + offset; }
};

/// The local frames of two bodies, at the size they have in the world, seen from one common frame, at both ends of an
/// interval of a step. Between them vertices move linearly. The common frame is
/// a's orientation at the start of the step, its origin moves with a's: what is
/// common to both motions, and large coordinates, cancel.
struct PairMotion {
  std::array<AffineMap, 2> a, b;  ///< at the start and at the end of the interval
  bool at_rest = false;           ///< both ends are the same

  /// The interval [t0, t1] of this one.
  PairMotion part(double t0, double t1) const;
  /// Bound of the distance that a point within `radius_a` and one within `radius_b` of their local
  /// origins move relative to each other. Of a size, not a proof.
  double displacement(double radius_a, double radius_b) const;
};

PairMotion pair_motion(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b) noexcept;

/// required_distance() at both ends of the step.
double required_distance(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                         double margin) noexcept;

}  // namespace encage
