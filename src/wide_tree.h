// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/mesh.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/asset_rules.h"

namespace encage {

/// Eight boxes side by side, as they lie in an asset. Float bounds, rounded outward.
struct alignas(64) WideNode {
  static constexpr int width = 8;
  static constexpr std::int32_t inner = 0, unused = -1;

  float lower[3][width];
  float upper[3][width];
  std::int32_t child[width];  ///< inner: a node after this one; leaf: first entry of WideTree::leaves
  std::int32_t count[width];  ///< leaf: its triangles; else `inner` or `unused`
};
static_assert(sizeof(WideNode) == 256);

/// A triangle where the tree has it: vertex indices, and its number in the mesh.
struct LeafTriangle {
  std::array<std::int32_t, 3> vertices;
  std::int32_t triangle;
};
static_assert(sizeof(LeafTriangle) == 16);

/// Bounding volume tree of a mesh in its own frame, 8 wide. Node 0 is the root;
/// used lanes come first. The same mesh gives the same tree on every machine.
struct WideTree {
  static constexpr int leaf_size = 2;   ///< triangles in a leaf, at most
  static constexpr int max_depth = 64;  ///< of any node, the root having 0: fixed stacks hold a traversal

  std::vector<WideNode> nodes;
  std::vector<LeafTriangle> leaves;  ///< leaf after leaf, every triangle once
};

/// Empty for a mesh without triangles. Vertices must be finite and exact in float32, indices in range.
WideTree build_wide_tree(const TriangleMesh& mesh);

/// A tree used in place.
struct WideTreeView {
  std::span<const WideNode> nodes;
  std::span<const LeafTriangle> leaves;

  WideTreeView() = default;
  WideTreeView(std::span<const WideNode> n, std::span<const LeafTriangle> l) : nodes(n), leaves(l) {}
  WideTreeView(const WideTree& tree) : nodes(tree.nodes), leaves(tree.leaves) {}  // NOLINT: a view of it
};

/// Proves that a traversal of the tree is safe and complete: every node but the
/// root is the child of exactly one earlier one, every triangle of the mesh is in exactly one
/// leaf, boxes contain what is below them, depth and leaf sizes keep their limits. Linear
/// time. Throws Error, its message starting with `place`.
void check_tree(const WideTreeView& tree, const MeshView& mesh, const std::string& place);

}  // namespace encage
