// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/motion/pair_motion.h"
#include "src/tree/mesh_tree.h"

#include <array>
#include <cstdint>

namespace encage {

/// The data of a body that a gate needs: the radius of its vertices about the local origin, and the grid of its tree.
struct GateBody {
  double radius = 0;
  TreeGrid grid;
  double scale = 1;  ///< of radius and grid: the maps' lengths are this many times as long
};

/// Oriented-box gate: proves that boxes of two mesh trees, or the slabs in them, stay apart during an interval. It
/// tests eight boxes at a time. These rest in the frame of their body; the boxes of the other body move past them on
/// straight lines, which are not quite the true paths. `gap` covers the difference and the rounding of float
/// (docs/guarantee.md, "Surfaces"). An axis that separates both ends in the same sense separates throughout, as
/// projections are linear in time. Lengths are in steps of the resting body's grid.
struct BoxGate {
  using Column = std::array<float, 3>;

  /// One body at rest, the other one moving.
  struct Side {
    /// The axes: the resting body's coordinates in lanes 0 to 2, the other body's own axes in lanes 4 to 6. The
    /// remaining lanes never separate.
    static constexpr int lanes = 8;
    using PerAxis = std::array<float, lanes>;
    std::array<std::array<PerAxis, 3>, 2> moving;       ///< [end][coordinate]: the axes in the other's grid coordinates
    std::array<std::array<PerAxis, 3>, 2> moving_size;  ///< absolute values of `moving`
    std::array<PerAxis, 2> moving_offset;               ///< [end]
    PerAxis gap;                                        ///< distance of projections that proves separation
    std::array<std::array<float, 3>, 3> oblique;        ///< [axis][coordinate]: the other's axes

    std::array<std::array<Column, 3>, 2> map;  ///< [end][column]: from the other tree's grid coordinates
    std::array<Column, 2> offset;              ///< [end]
    float step = 0;                            ///< length of a grid step in the common frame
    float normal_scale = 0;                    ///< scales a mapped normal so that heights stay the same
    float moving_slab_gap = 0;                 ///< distance along the moving slab's normal that proves separation
    bool far = false;                          ///< tests the direction between boxes, too
    bool works = false;                        ///< if false, nothing is proven
  };
  alignas(64) Side a;  ///< a at rest, b moving
  alignas(64) Side b;  ///< b at rest, a moving
  int ends = 2;        ///< 1 if both are at rest

  /// Builds a gate that proves distances of more than `distance` in the common frame. With `directions` it also tests
  /// the direction between boxes where that distance is large beside many of them, and their own axes prove little.
  BoxGate(const PairMotion& motion, const GateBody& body_a, const GateBody& body_b, double distance,
          bool directions = false);
};

/// Called with ranges of leaf triangles whose boxes are not proven apart; returns false to stop.
using VisitLeaves = bool (*)(void* context, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b,
                             std::int32_t count_b);

/// Visits every pair of leaves that the gate does not prove apart, once, in an order that depends on the arguments
/// alone, not on the instruction set. Returns false if a visitor stopped it. `steps`, if given, loses one for each pair
/// of boxes that is looked at, and a visitor may take more from it; where it is negative the traversal stops, too.
bool visit_leaf_pairs(const MeshTreeView& a, const MeshTreeView& b, const BoxGate& gate, VisitLeaves visit,
                      void* context, std::int64_t* steps = nullptr);

}  // namespace encage
