// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/cut_tree.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace encage::covers {
namespace {

double size_of(const WideNode& node, int lane, LargestBy largest) {
  double sum = 0, squares = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = node.upper[axis][lane] - node.lower[axis][lane];
    sum += extent;
    squares += extent * extent;
  }
  if (largest == LargestBy::diagonal) return std::sqrt(squares);
  return sum + 8.0 * (node.slab_upper[lane] - node.slab_lower[lane]);
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

CutTree cut_tree(const WideTreeView& tree, std::int64_t boxes, LargestBy largest) {
  CutTree cut;
  cut.places.assign(tree.nodes.size(), -1);
  std::priority_queue<Closed> closed;
  const auto keep = [&](std::int32_t index) {
    cut.places[index] = static_cast<std::int32_t>(cut.nodes.size());
    cut.nodes.push_back(index);
    const WideNode& node = tree.nodes[index];
    for (int lane = 0; lane < WideNode::width; ++lane) {
      if (node.count(lane) == WideNode::unused) continue;
      ++cut.boxes;
      if (node.count(lane) == WideNode::inner) closed.push({size_of(node, lane, largest), node.child(lane)});
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

std::vector<std::int32_t> vertices_below(const WideTreeView& tree, const WideNode& node, int lane) {
  std::vector<std::int32_t> vertices;
  struct Below {
    const WideNode* node;
    int lane;
  };
  std::vector<Below> todo{{&node, lane}};
  while (!todo.empty()) {
    const Below below = todo.back();
    todo.pop_back();
    const std::int32_t child = below.node->child(below.lane), count = below.node->count(below.lane);
    if (count == WideNode::inner) {
      for (int k = 0; k < WideNode::width; ++k) todo.push_back({&tree.nodes[child], k});
      continue;
    }
    for (std::int32_t i = child; i < child + count; ++i) {
      const auto& corners = tree.leaves[i].vertices;
      vertices.insert(vertices.end(), corners.begin(), corners.end());
    }
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

}  // namespace encage::covers
