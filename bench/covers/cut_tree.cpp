// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/cut_tree.h"

#include <queue>

namespace encage::covers {
namespace {

double size_of(const MeshNode& node, int lane) {
  double sum = 8.0 * (node.slab_upper[lane] - node.slab_lower[lane]);
  for (int axis = 0; axis < 3; ++axis) sum += node.upper[axis][lane] - node.lower[axis][lane];
  return sum;
}

/// An inner lane, which may be opened.
struct Closed {
  double size;
  std::int32_t child;
  bool operator<(const Closed& other) const {
    return size != other.size ? size < other.size : child > other.child;  // ties: the first node
  }
};

}  // namespace

CutTree cut_tree(const MeshTreeView& tree, std::int64_t boxes) {
  CutTree cut;
  cut.places.assign(tree.nodes.size(), -1);
  std::priority_queue<Closed> closed;
  const auto keep = [&](std::int32_t index) {
    cut.places[index] = static_cast<std::int32_t>(cut.nodes.size());
    cut.nodes.push_back(index);
    const MeshNode& node = tree.nodes[index];
    for (int lane = 0; lane < MeshNode::width; ++lane) {
      if (node.count(lane) == MeshNode::unused) continue;
      ++cut.boxes;
      if (node.count(lane) == MeshNode::inner) closed.push({size_of(node, lane), node.child(lane)});
    }
  };
  keep(0);
  while (cut.boxes < boxes && !closed.empty()) {
    const std::int32_t child = closed.top().child;
    closed.pop();
    --cut.boxes;
    keep(child);
  }
  return cut;
}

}  // namespace encage::covers
