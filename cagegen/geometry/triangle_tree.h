// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/float4.h"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace encage::makers {

/// Four-wide bounding volume tree over boxes, one primitive a leaf lane. Boxes are float, rounded outward. Primitives
/// may move (update) or go (remove); boxes then only grow, so rebuild after many changes.
class TriangleTree {
 public:
  static constexpr std::int32_t no_slot = -1;

  TriangleTree() = default;
  /// Primitives with an empty box are left out.
  explicit TriangleTree(std::span<const Eigen::AlignedBox3d> boxes) { build(boxes); }

  void build(std::span<const Eigen::AlignedBox3d> boxes);
  bool empty() const { return nodes_.empty(); }

  /// Renumbers the primitives in the order of the leaves, so that data stored in that order lie together as they are
  /// visited. Returns the old number of each.
  std::vector<std::int32_t> renumber();

  /// Fits all boxes anew, tightly, without changing the shape of the tree.
  void refit(std::span<const Eigen::AlignedBox3d> boxes);

  /// Enlarges the primitive's box and all above it to hold `box`.
  void update(std::int32_t primitive, const Eigen::AlignedBox3d& box);
  void remove(std::int32_t primitive);

  /// Calls visit(primitive) for every primitive whose box is accepted by test(low, high): arrays [3] of Float4,
  /// returning a Mask4. If visit returns true, that ends the search.
  template <class Test, class Visit>
  void traverse(const Test& test, const Visit& visit) const {
    if (nodes_.empty()) return;
    std::int32_t stack[128];
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const Node& node = nodes_[stack[--size]];
      const Boxes boxes(node);
      const Mask4 accepted = test(boxes.low, boxes.high);
      for (int lane = 3; lane >= 0; --lane) {
        if (!accepted.lane(lane) || node.kind[lane] == Kind::none) continue;
        if (node.kind[lane] == Kind::leaf) {
          if (ends(visit, node.child[lane])) return;
        } else {
          stack[size++] = node.child[lane];
        }
      }
    }
  }

  /// The same, boxes of higher rank(low, high) first where there is a choice.
  template <class Test, class Rank, class Visit>
  void traverse_ranked(const Test& test, const Rank& rank, const Visit& visit) const {
    if (nodes_.empty()) return;
    std::int32_t stack[128];
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
      // Tested again when its turn comes: the test may have become stricter meanwhile.
      const Node& node = nodes_[stack[--size]];
      const Boxes boxes(node);
      const Mask4 accepted = test(boxes.low, boxes.high);
      const Float4 ranks = rank(boxes.low, boxes.high);
      int order[4];
      int count = 0;
      for (int lane = 0; lane < 4; ++lane) {
        if (!accepted.lane(lane) || node.kind[lane] == Kind::none) continue;
        int at = count++;
        for (; at > 0 && ranks.lanes[order[at - 1]] > ranks.lanes[lane]; --at) order[at] = order[at - 1];
        order[at] = lane;
      }
      for (int i = 0; i < count; ++i) {
        if (node.kind[order[i]] == Kind::inner) stack[size++] = node.child[order[i]];
      }
      for (int i = count - 1; i >= 0; --i) {
        if (node.kind[order[i]] == Kind::leaf && ends(visit, node.child[order[i]])) return;
      }
    }
  }

 private:
  template <class Visit>
  static bool ends(const Visit& visit, std::int32_t primitive) {
    if constexpr (std::is_same_v<decltype(visit(primitive)), bool>) {
      return visit(primitive);
    } else {
      visit(primitive);
      return false;
    }
  }

  enum class Kind : std::uint8_t { none, inner, leaf };
  struct Node {
    float low[3][4];
    float high[3][4];
    std::int32_t child[4];
    std::array<Kind, 4> kind{};
    std::int32_t parent = no_slot;  ///< node * 4 + lane
  };

  /// The four boxes of a node, loaded.
  struct Boxes {
    explicit Boxes(const Node& node) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = Float4::load(node.low[axis]);
        high[axis] = Float4::load(node.high[axis]);
      }
    }
    Float4 low[3];
    Float4 high[3];
  };

  std::int32_t build_node(std::span<std::int32_t> primitives, std::span<const Eigen::AlignedBox3d> boxes,
                          std::int32_t parent);
  static void set_box(Node& node, int lane, const Eigen::AlignedBox3d& box);

  std::vector<Node> nodes_;
  std::vector<std::int32_t> slot_;  ///< per primitive: node * 4 + lane
};

}  // namespace encage::makers
