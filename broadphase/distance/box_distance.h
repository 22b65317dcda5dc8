// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/separation/box_gate.h"

#include <array>
#include <cstdint>

namespace encage {

/// Lower bounds of the distances between boxes of two body-frame trees, at rest: what BoxGate is for one distance.
/// In double, as float would see nothing but its own rounding where bodies are far apart compared with their size.
/// Boxes that are tested at a time are those of a node, in the frame of their body; lengths are places of its grid.
struct BoxDistance {
  /// One body whose nodes are opened, and the other one, whose boxes are held against what is in them.
  struct Side {
    /// Axes: the opened body's coordinates, then the other's.
    static constexpr int axes = 6;
    std::array<std::array<double, axes>, 3> other;       ///< [coordinate]: the axes in the other's places
    std::array<std::array<double, axes>, 3> other_size;  ///< absolute values of `other`
    std::array<double, axes> other_offset;
    std::array<std::array<double, 3>, 3> turned;  ///< [axis][coordinate]: the other's axes, of length 1
    std::array<double, 3> offset;                 ///< of the other's places
    double ratio = 1;                             ///< of the steps of both grids, in the world
    double error = 0;                             ///< of a distance, in places
    double unit = 0;                              ///< one place in the world, rounded down
    double world_error = 0;
    bool works = false;  ///< else nothing is known
  };
  Side a;  ///< a's nodes opened
  Side b;

  /// Maps to a common frame, in which places are off by `error` at most.
  BoxDistance(const AffineMap& map_a, const GateBody& body_a, const AffineMap& map_b, const GateBody& body_b,
              double error);
};

/// Called with ranges of leaf triangles; returns the distance from which on nothing is to be visited any more.
using VisitNearLeaves = double (*)(void* context, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b,
                                   std::int32_t count_b);

/// Visits pairs of leaves, near ones first, and none of which the distance is at least `limit` or what the last visit
/// returned. The same on every instruction set.
void visit_near_leaves(const MeshTreeView& a, const MeshTreeView& b, const BoxDistance& bounds, double limit,
                       VisitNearLeaves visit, void* context);

}  // namespace encage
