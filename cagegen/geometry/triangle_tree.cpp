// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace encage::makers {

namespace {

float round_down(double x) {
  const float f = static_cast<float>(x);
  return static_cast<double>(f) <= x ? f : std::nextafterf(f, -std::numeric_limits<float>::infinity());
}

float round_up(double x) { return -round_down(-x); }

/// Orders the primitives so that the first half lies lower along the longest axis of their centres.
std::size_t split(std::span<std::int32_t> primitives, std::span<const Eigen::AlignedBox3d> boxes) {
  Eigen::AlignedBox3d centres;
  for (const std::int32_t p : primitives) centres.extend(boxes[p].min() + boxes[p].max());
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const std::size_t half = primitives.size() / 2;
  const auto key = [&](std::int32_t p) { return boxes[p].min()[axis] + boxes[p].max()[axis]; };
  std::nth_element(primitives.begin(), primitives.begin() + static_cast<std::ptrdiff_t>(half), primitives.end(),
                   [&](std::int32_t a, std::int32_t b) {
                     const double ka = key(a);
                     const double kb = key(b);
                     return ka != kb ? ka < kb : a < b;
                   });
  return half;
}

}  // namespace

void TriangleTree::set_box(Node& node, int lane, const Eigen::AlignedBox3d& box) {
  for (int axis = 0; axis < 3; ++axis) {
    node.low[axis][lane] = round_down(box.min()[axis]);
    node.high[axis][lane] = round_up(box.max()[axis]);
  }
}

void TriangleTree::build(std::span<const Eigen::AlignedBox3d> boxes) {
  nodes_.clear();
  slot_.assign(boxes.size(), no_slot);
  std::vector<std::int32_t> primitives;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    if (!boxes[i].isEmpty()) primitives.push_back(static_cast<std::int32_t>(i));
  }
  nodes_.reserve(primitives.size() / 2 + 1);
  if (!primitives.empty()) build_node(primitives, boxes, no_slot);
}

std::int32_t TriangleTree::build_node(std::span<std::int32_t> primitives, std::span<const Eigen::AlignedBox3d> boxes,
                                      std::int32_t parent) {
  const std::int32_t index = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_[index].parent = parent;
  std::array<std::span<std::int32_t>, 4> parts;
  int count = 0;
  if (primitives.size() <= 4) {
    for (std::size_t i = 0; i < primitives.size(); ++i) parts[count++] = primitives.subspan(i, 1);
  } else {
    const std::size_t half = split(primitives, boxes);
    for (const auto side : {primitives.first(half), primitives.subspan(half)}) {
      if (side.size() == 1) {
        parts[count++] = side;
        continue;
      }
      const std::size_t quarter = split(side, boxes);
      parts[count++] = side.first(quarter);
      parts[count++] = side.subspan(quarter);
    }
  }
  for (int lane = 0; lane < 4; ++lane) {
    if (lane >= count) {
      for (int axis = 0; axis < 3; ++axis) {
        nodes_[index].low[axis][lane] = std::numeric_limits<float>::max();
        nodes_[index].high[axis][lane] = -std::numeric_limits<float>::max();
      }
      continue;
    }
    Eigen::AlignedBox3d box;
    for (const std::int32_t p : parts[lane]) box.extend(boxes[p]);
    set_box(nodes_[index], lane, box);
    if (parts[lane].size() == 1) {
      nodes_[index].kind[lane] = Kind::leaf;
      nodes_[index].child[lane] = parts[lane][0];
      slot_[parts[lane][0]] = index * 4 + lane;
    } else {
      const std::int32_t child = build_node(parts[lane], boxes, index * 4 + lane);
      nodes_[index].kind[lane] = Kind::inner;
      nodes_[index].child[lane] = child;
    }
  }
  return index;
}

std::vector<std::int32_t> TriangleTree::renumber() {
  std::vector<std::int32_t> old_number;
  std::vector<std::int32_t> slot;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    for (int lane = 0; lane < 4; ++lane) {
      if (nodes_[n].kind[lane] != Kind::leaf) continue;
      old_number.push_back(nodes_[n].child[lane]);
      nodes_[n].child[lane] = static_cast<std::int32_t>(slot.size());
      slot.push_back(static_cast<std::int32_t>(n) * 4 + lane);
    }
  }
  slot_ = std::move(slot);
  return old_number;
}

void TriangleTree::refit(std::span<const Eigen::AlignedBox3d> boxes) {
  // Children have higher numbers than their parents.
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    for (int lane = 0; lane < 4; ++lane) {
      if (node.kind[lane] == Kind::leaf) set_box(node, lane, boxes[node.child[lane]]);
      if (node.kind[lane] != Kind::inner) continue;
      const Node& child = nodes_[node.child[lane]];
      for (int axis = 0; axis < 3; ++axis) {
        float low = std::numeric_limits<float>::max();
        float high = -low;
        for (int k = 0; k < 4; ++k) {
          if (child.kind[k] == Kind::none) continue;
          low = std::min(low, child.low[axis][k]);
          high = std::max(high, child.high[axis][k]);
        }
        node.low[axis][lane] = low;
        node.high[axis][lane] = high;
      }
    }
  }
}

void TriangleTree::update(std::int32_t primitive, const Eigen::AlignedBox3d& box) {
  // The leaf takes the new box; its ancestors only grow.
  std::int32_t slot = slot_[primitive];
  set_box(nodes_[slot / 4], slot % 4, box);
  float low[3];
  float high[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = nodes_[slot / 4].low[axis][slot % 4];
    high[axis] = nodes_[slot / 4].high[axis][slot % 4];
  }
  for (slot = nodes_[slot / 4].parent; slot != no_slot; slot = nodes_[slot / 4].parent) {
    Node& node = nodes_[slot / 4];
    const int lane = slot % 4;
    bool grown = false;
    for (int axis = 0; axis < 3; ++axis) {
      if (low[axis] < node.low[axis][lane]) {
        node.low[axis][lane] = low[axis];
        grown = true;
      }
      if (high[axis] > node.high[axis][lane]) {
        node.high[axis][lane] = high[axis];
        grown = true;
      }
    }
    if (!grown) break;
  }
}

void TriangleTree::remove(std::int32_t primitive) {
  const std::int32_t slot = slot_[primitive];
  nodes_[slot / 4].kind[slot % 4] = Kind::none;
  slot_[primitive] = no_slot;
}

}  // namespace encage::makers
