// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/tree/mesh_tree.h"

#include <array>
#include <cstdint>

namespace encage {

/// Stack size for a depth-first traversal that keeps all unvisited nodes on its stack: every node on a path adds fewer
/// entries than its width.
inline constexpr int traversal_stack_size = MeshNode::width * (MeshTree::max_depth + 2);

/// Depth-first traversal of the nodes of a tree that is not empty: calls visit(node, descend) -> bool from the root on,
/// until it returns false; returns false if it did. The visitor calls descend(child) for each child to be visited, and
/// the last of these is visited first.
template <class Visit>
[[gnu::always_inline]] inline bool visit_nodes(const MeshTreeView& tree, Visit&& visit) {
  std::array<std::int32_t, traversal_stack_size> stack;
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const MeshNode& node = tree.nodes[stack[--size]];
    if (!visit(
            node, [&](std::int32_t child) __attribute__((always_inline)) { stack[size++] = child; }))
      return false;
  }
  return true;
}

}  // namespace encage
