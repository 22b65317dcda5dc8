// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

namespace encage {

/// Whether queries may use the pose: finite, and its linear part farther than
/// 1e-9 from orthonormal neither in any direction.
bool is_usable(const Eigen::Isometry3d& pose) noexcept;

/// Upper bound of the spectral norm of R^T R - I, rounding included.
double departure_from_rigid(const Eigen::Matrix3d& linear) noexcept;

/// Where a body is, and how large.
struct Placement {
  const Eigen::Isometry3d& pose;
  double scale;

  Placement(const Eigen::Isometry3d& p, double s = 1) : pose(p), scale(s) {}  // NOLINT: mostly a pose

  /// Of the shape's local frame, in the world.
  Eigen::Vector3d origin(const Shape& shape) const { return pose * (scale * shape.origin); }
};

/// The local frame of b seen from the local frame of a, both at the size they have in the world:
/// x -> rotation * x + translation.
struct PairFrame {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;

  Eigen::Vector3d map(const Eigen::Vector3d& x) const { return rotation * x + translation; }
};

/// From a's local origin to b's, in the world.
Eigen::Vector3d origin_offset(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b) noexcept;

PairFrame relative_frame(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b) noexcept;

/// Distance in the frames of a pair, as computed, that proves a distance of
/// more than `margin` between the surfaces in the world. It covers, with room
/// to decide containment by a computed point (docs/guarantee.md, "Frames"): the
/// rounding of relative_frame() and map(), of projections on an axis and of box
/// tests, and the poses' departure from rigid.
double required_distance(const Shape& a, const Placement& at_a, const Shape& b, const Placement& at_b,
                         double margin) noexcept;

/// True if the boxes are proven farther apart than `margin`.
bool boxes_apart(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b, double margin) noexcept;

/// An upper bound of the largest n.x over the vertices, as computed: at most 4 eps |n| radius below
/// the exact one, and no more than `tolerance` above it.
double support(const Surface& surface, const Eigen::Vector3d& n, double tolerance = 0) noexcept;

/// World box of a body that is no compound at one pose, rounding included: that of a mesh or cage
/// with few vertices; without one that of the body, wider than need be by 2^-8 of its radius at most.
Eigen::AlignedBox3d pose_box(const Shape& shape, const Placement& at) noexcept;

/// world_box() of a motion that is usable.
Eigen::AlignedBox3d usable_box(const Shape& shape, const Motion& motion) noexcept;

/// Cheaper and looser: the box of the ball about the local origin. It contains pose_box(). Of a compound, the box of
/// its turned box.
Eigen::AlignedBox3d ball_box(const Shape& shape, const Placement& at) noexcept;

}  // namespace encage
