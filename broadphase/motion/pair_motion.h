// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/motion/pair_frame.h"

#include <array>

namespace encage {

/// Maps from the local frames of two bodies, including their scales, to a common frame, at both ends of an interval of
/// a step. Vertices move linearly between the ends. The common frame has a's orientation at the start of the step, and
/// its origin moves with a's: common motion cancels, and so do large coordinates.
struct PairMotion {
  std::array<AffineMap, 2> a, b;  ///< at the start and at the end of the interval
  bool at_rest = false;           ///< start and end are the same

  /// Returns the motion during the interval [t0, t1] of this one.
  PairMotion part(double t0, double t1) const;
  /// Estimates how far a point within `radius_a` of its local origin and one within `radius_b` move relative to each
  /// other. The estimate proves nothing.
  double displacement(double radius_a, double radius_b) const;
};

PairMotion pair_motion(const LocalFrame& a, const Motion& motion_a, const LocalFrame& b,
                       const Motion& motion_b) noexcept;

/// The largest required_distance() of all combinations of start and end poses.
double required_distance(const LocalFrame& a, const Motion& motion_a, const LocalFrame& b, const Motion& motion_b,
                         double margin) noexcept;

}  // namespace encage
