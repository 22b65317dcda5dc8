// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <vector>

namespace encage {

/// One box of a tree. The children of an inner node lie side by side.
struct BvhNode {
  float lower[3];
  float upper[3];
  std::int32_t first;  ///< leaf: first entry of Bvh::order; inner node: first child
  std::int32_t count;  ///< leaf: number of triangles; inner node: 0

  bool leaf() const { return count > 0; }
};
static_assert(sizeof(BvhNode) == 32);

/// Binary tree of axis-aligned boxes over the triangles of a mesh, in the frame of its vertices. Boxes are rounded
/// outward to float; node 0 is the root. Built by the binned surface-area heuristic (Wald 2007, "On fast construction
/// of SAH-based bounding volume hierarchies"), ties broken by index: the same mesh gives the same tree on every
/// machine.
struct Bvh {
  static constexpr int leaf_size = 4;   ///< largest number of triangles in a leaf
  static constexpr int max_depth = 64;  ///< of any node; the root has depth 0. Bounds the stack of a traversal

  std::vector<BvhNode> nodes;
  std::vector<std::int32_t> order;  ///< triangle indices, leaf after leaf
};

/// Builds the tree; it is empty for a mesh without triangles. Vertices must be finite and indices in range.
Bvh build_bvh(const TriangleMesh& mesh);

}  // namespace encage
