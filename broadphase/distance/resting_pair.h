// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/motion/pair_motion.h"

namespace encage {

/// Two bodies at rest in the world, seen from a's local origin: the world's orientation, so that distances are the
/// world's own, whatever rotations are off from rigid; and without large coordinates where bodies are near each other.
struct RestingPair {
  AffineMap a, b;  ///< from the local frames, at the size that bodies have in the world
  double scale_a, scale_b;
  Eigen::Vector3d origin;  ///< of the frame, in the world
  /// Covers the places of two vertices that are computed by the maps, the rounding of their distance and of projections
  /// (docs/guarantee.md, "Distance").
  double error = 0;

  /// At the start of the motions.
  RestingPair(const LocalFrame& local_a, const Motion& motion_a, const LocalFrame& local_b,
              const Motion& motion_b) noexcept;

  /// Covers the place of a vertex that is mapped from one local frame to the other.
  double located() const { return 2 * error; }
  /// b's local frame seen from a's, or the other way round; at the same size.
  AffineMap b_to_a() const noexcept;
  AffineMap a_to_b() const noexcept;
};

}  // namespace encage
