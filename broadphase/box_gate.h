// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/pair_motion.h"

#include <array>
#include <cstdint>

namespace encage {

/// Separating axes for pairs of body-frame boxes during an interval: fixed axes
/// in the common frame, on which both ends of the interval are tested.
/// Projections of linearly moving points are linear in time, so an axis that separates
/// both ends in the same sense separates throughout. In float; `gap` covers rounding
/// (docs/guarantee.md, "Surfaces").
struct BoxGate {
  static constexpr int axis_count = 15;
  static constexpr int axis_lanes = 16;  ///< arrays are padded for SIMD; the last axis is never separating
  using PerAxis = std::array<float, axis_lanes>;

  /// One body: a box with centre c and half sizes h projects to direction . c +- size . h.
  struct Side {
    std::array<std::array<PerAxis, 3>, 2> direction;  ///< [end][coordinate][axis]
    std::array<std::array<PerAxis, 3>, 2> size;       ///< absolute values of `direction`
    std::array<PerAxis, 2> offset;                    ///< [end][axis]; of the other side: its negative
    int own = 0;                                      ///< first of the box's own axes; out of range if it has none
  };
  alignas(64) Side a;
  alignas(64) Side b;
  int ends = 2;   ///< 1: at rest
  float gap = 0;  ///< distance of projections that proves separation; infinite if nothing can be proven

  /// Proves distances of more than `distance` in the common frame between surfaces within the radii.
  BoxGate(const PairMotion& motion, double radius_a, double radius_b, double distance);
};

/// Called with ranges of leaf triangles whose boxes are not proven apart; returns false to stop.
using VisitLeaves = bool (*)(void* context, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b,
                             std::int32_t count_b);

/// Visits every pair of leaves that the gate does not prove apart, in an order
/// that depends on nothing but the arguments: neither on the instruction set. False if a visit stopped it.
bool visit_leaf_pairs(const WideTreeView& a, const WideTreeView& b, const BoxGate& gate, VisitLeaves visit,
                      void* context);

}  // namespace encage
