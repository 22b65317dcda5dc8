// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/separation/box_gate.h"

#include <array>
#include <cstdint>

namespace encage {

/// Lower bounds of the distances between boxes of two mesh trees at rest. BoxGate is the counterpart for one given
/// distance. The bounds are computed in double: float would show nothing but its own rounding where bodies are far
/// apart compared with their size. The boxes of one node are tested together, in the frame of their body; lengths are
/// in steps of its grid.
struct BoxDistance {
  /// The body whose nodes are opened, and the other body, whose boxes are tested against the boxes in the node.
  struct Side {
    /// The axes are the opened body's coordinates, then the other body's.
    static constexpr int axes = 6;
    std::array<std::array<double, axes>, 3> other;       ///< [coordinate]: the axes in the other's grid coordinates
    std::array<std::array<double, axes>, 3> other_size;  ///< absolute values of `other`
    std::array<double, axes> other_offset;
    std::array<std::array<double, 3>, 3> turned;  ///< [axis][coordinate]: the other body's axes, of length 1
    std::array<double, 3> offset;                 ///< of the other's origin of grid coordinates
    double ratio = 1;                             ///< of the steps of both grids, in the world
    double error = 0;                             ///< of a distance, in grid steps
    double unit = 0;                              ///< one grid step in world units, rounded down
    double world_error = 0;
    bool works = false;  ///< if false, every bound is 0
  };
  Side a;  ///< for opening a's nodes
  Side b;

  /// Takes maps to a common frame, in which positions are off by `error` at most.
  BoxDistance(const AffineMap& map_a, const GateBody& body_a, const AffineMap& map_b, const GateBody& body_b,
              double error);
};

/// Called with ranges of leaf triangles. Returns the distance from which on pairs need not be visited any more.
using VisitNearLeaves = double (*)(void* context, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b,
                                   std::int32_t count_b);

/// Visits pairs of leaves, near ones first, except those whose distance is at least `limit` or the last visitor's
/// result. The visits are the same on every instruction set. `steps`, if given, loses one for each pair of boxes that
/// is looked at, and a visitor may take more from it; where it is negative the traversal stops. Returns a lower bound
/// of the distances of pairs nearer than the limit that were not visited for this reason; infinity if there are none.
double visit_near_leaves(const MeshTreeView& a, const MeshTreeView& b, const BoxDistance& bounds, double limit,
                         VisitNearLeaves visit, void* context, std::int64_t* steps = nullptr);

}  // namespace encage
