// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/motion/pair_motion.h"

namespace encage {

/// Two bodies at rest in a frame with its origin at a's local origin and the world's orientation. Distances are
/// therefore the world's own, even if rotations are not exactly rigid, and coordinates are small where bodies are near
/// each other.
struct RestingPair {
  AffineMap a, b;  ///< from the local frames, including the scale
  double scale_a, scale_b;
  Eigen::Vector3d origin;  ///< of the frame, in world coordinates
  /// Bounds the errors of two vertices that the maps compute, and the rounding of their distance and of projections
  /// (docs/guarantee.md, "Distance").
  double error = 0;

  /// Takes the bodies at the start of their motions.
  RestingPair(const LocalFrame& local_a, const Motion& motion_a, const LocalFrame& local_b,
              const Motion& motion_b) noexcept;
  /// Takes maps to any common frame, which include the scales; the origin is not known.
  RestingPair(const AffineMap& map_a, double size_a, const AffineMap& map_b, double size_b,
              double error_of_both) noexcept
      : a(map_a), b(map_b), scale_a(size_a), scale_b(size_b), origin(0, 0, 0), error(error_of_both) {}

  /// Bounds the error of a vertex that is mapped from one local frame to the other.
  double located() const { return 2 * error; }
  /// Maps from one body's local frame to the other's, including the scales.
  AffineMap b_to_a() const noexcept;
  AffineMap a_to_b() const noexcept;
};

}  // namespace encage
