// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/affine_map.h>
#include <encage/motion.h>

namespace encage {

/// Origin and extent of the coordinates of a surface in the body frame. Bounds of rounding need nothing else of a
/// shape.
struct LocalFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< body frame = origin + local frame
  double radius = 0;                                 ///< largest distance of a vertex from the local origin, rounded up

  /// Bounds the distance of a vertex from the origin of the body frame.
  double reach() const { return radius + origin.norm(); }
};

/// Pose and scale of a body at one time.
struct Placement {
  const Eigen::Isometry3d& pose;
  double scale;

  Placement(const Eigen::Isometry3d& p, double s = 1) : pose(p), scale(s) {}  // NOLINT: mostly a pose

  /// Returns the local origin in world coordinates.
  Eigen::Vector3d origin(const LocalFrame& local) const { return pose * (scale * local.origin); }
};

/// Returns the vector from a's local origin to b's, in world coordinates.
Eigen::Vector3d origin_offset(const LocalFrame& a, const Placement& at_a, const LocalFrame& b,
                              const Placement& at_b) noexcept;

/// Returns the map from b's local frame to a's, both at the size that they have in the world.
AffineMap relative_frame(const LocalFrame& a, const Placement& at_a, const LocalFrame& b,
                         const Placement& at_b) noexcept;

/// Returns the distance in the frame of a pair that proves a distance of more than `margin` between the surfaces in the
/// world. It covers the rounding of relative_frame(), of the map that it returns, of projections on an axis and of box
/// tests, and the poses' departure from rigid, with room to decide containment by a computed point (docs/guarantee.md,
/// "Frames").
double required_distance(const LocalFrame& a, const Placement& at_a, const LocalFrame& b, const Placement& at_b,
                         double margin) noexcept;

}  // namespace encage
