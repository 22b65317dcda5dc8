// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/affine_map.h>
#include <encage/shape.h>

namespace encage {

/// Where the coordinates of a surface lie in the body frame, and how far they reach. Bounds of rounding need no more of
/// a shape.
struct LocalFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< body frame = origin + local frame
  double radius = 0;                                 ///< largest distance of a vertex from the local origin, rounded up

  /// Bound of the distance of a vertex from the origin of the body frame.
  double reach() const { return radius + origin.norm(); }
};

/// Pose and scale of a body at one time.
struct Placement {
  const Eigen::Isometry3d& pose;
  double scale;

  Placement(const Eigen::Isometry3d& p, double s = 1) : pose(p), scale(s) {}  // NOLINT: mostly a pose

  /// The local origin in the world.
  Eigen::Vector3d origin(const LocalFrame& local) const { return pose * (scale * local.origin); }
};

/// From a's local origin to b's, in the world.
Eigen::Vector3d origin_offset(const LocalFrame& a, const Placement& at_a, const LocalFrame& b,
                              const Placement& at_b) noexcept;

/// Maps b's local frame to a's, both at the size that they have in the world.
AffineMap relative_frame(const LocalFrame& a, const Placement& at_a, const LocalFrame& b,
                         const Placement& at_b) noexcept;

/// The distance that has to be computed in the frame of a pair to prove a distance of more than `margin` between the
/// surfaces in the world. It covers the rounding of relative_frame(), of the map that it returns, of projections on an
/// axis and of box tests, and the poses' departure from rigid, with room to decide containment by a computed point
/// (docs/guarantee.md, "Frames").
double required_distance(const LocalFrame& a, const Placement& at_a, const LocalFrame& b, const Placement& at_b,
                         double margin) noexcept;

}  // namespace encage
