// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "src/tree/mesh_arrays.h"

#include <cstdint>
#include <vector>

namespace encage::covers {

/// The top of a tree: its largest boxes, as the traversal of box_gate.h sees them, are opened until there are enough.
struct CutTree {
  std::vector<std::int32_t> nodes;   ///< that are kept, parents first
  std::vector<std::int32_t> places;  ///< of every node of the tree: its index in `nodes`, -1 where it is cut off
  std::int64_t boxes = 0;            ///< that are not opened: together they hold every triangle

  /// Where a lane of a kept node leads among `nodes`; -1 for a box that is not opened.
  std::int32_t child(const MeshNode& node, int lane) const {
    return node.count(lane) == MeshNode::inner ? places[node.child(lane)] : -1;
  }
};

/// At least `boxes` of them, at most 7 more, or all leaves if there are fewer. The tree must not be empty.
CutTree cut_tree(const MeshTreeView& tree, std::int64_t boxes);

}  // namespace encage::covers
