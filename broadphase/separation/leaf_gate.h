// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/separation/triangle_pair.h"
#include "src/tree/mesh_tree.h"

#include <array>
#include <cstdint>

namespace encage {

/// The triangles of a leaf side by side, in the common frame of a pair.
struct LeafLanes {
  static constexpr int width = MeshTree::leaf_size;
  using Lanes = std::array<double, width>;
  using Corners = std::array<std::array<Lanes, 3>, 3>;  ///< [corner][coordinate]

  alignas(64) std::array<Corners, 2> corners;  ///< [end]; unused lanes repeat a triangle

  void set(int lane, const MovingTriangle& triangle, int ends);
  MovingTriangle triangle(int lane, int ends) const;
};

/// Returns the bits of the `count` triangles of `b` that are not proven to stay farther than `distance` > 0 from
/// triangle `lane` of `a`. It tries axes that are cheap for all of them at once: coordinates, the direction between the
/// triangles, their normals, and cross products of their edges (at rest only). One axis has to separate all `ends`, 1
/// at rest or 2 during an interval, in the same sense. `distance` covers rounding as for triangles_apart(). The result
/// is the same on every instruction set.
std::uint32_t lanes_not_apart(const LeafLanes& a, int lane, const LeafLanes& b, int count, int ends, double distance);

}  // namespace encage
