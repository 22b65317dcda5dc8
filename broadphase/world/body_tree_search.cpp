// SPDX-License-Identifier: Apache-2.0
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/world/body_tree_search.cpp"
#include <hwy/foreach_target.h>  // compiles the following once for every instruction set

#include "broadphase/world/body_tree.h"

#include <hwy/highway.h>
// clang-format on

#ifndef ENCAGE_BODY_TREE_SEARCH
#define ENCAGE_BODY_TREE_SEARCH
namespace encage {

/// The nodes of the tree as searches see them.
struct BoxNodes {
  static constexpr int most_levels = 11;
  std::array<const BoxLanes*, most_levels> levels{};
  int height = 0;
  std::int32_t leaf_nodes = 0;
};

/// A search for the pairs of moved leaves.
struct MovedLeaves {
  const std::uint8_t* lanes = nullptr;  // for each node of level 0, bits of the lanes that have moved
  bool all = false;
  double margin = 0;
  void (*visit)(const void* context, std::int32_t a, std::int32_t b, std::uint64_t lanes) = nullptr;
  const void* context = nullptr;
};

}  // namespace encage
#endif

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

namespace {

using Floats = hn::CappedTag<float, BoxLanes::width>;

/// Bits of the lanes that overlap the box.
HWY_INLINE unsigned overlapping(const BoxLanes& lanes, const FloatBox& box) {
  const Floats d;
  unsigned bits = 0;
  for (std::size_t i = 0; i < BoxLanes::width; i += hn::Lanes(d)) {
    auto hit = hn::Le(hn::Load(d, lanes.lower[0].data() + i), hn::Set(d, box.upper[0]));
    hit = hn::And(hit, hn::Le(hn::Set(d, box.lower[0]), hn::Load(d, lanes.upper[0].data() + i)));
    for (std::size_t k = 1; k < 3; ++k) {
      hit = hn::And(hit, hn::Le(hn::Load(d, lanes.lower[k].data() + i), hn::Set(d, box.upper[k])));
      hit = hn::And(hit, hn::Le(hn::Set(d, box.lower[k]), hn::Load(d, lanes.upper[k].data() + i)));
    }
    std::uint8_t part[8] = {};
    hn::StoreMaskBits(d, hit, part);
    bits |= static_cast<unsigned>(part[0]) << i;
  }
  return bits;
}

/// Calls visit(leaf node, lane of its parent) for every node of level 0 whose box overlaps `box`, except nodes before
/// `first`. Returns the number of visits.
template <class Visit>
HWY_INLINE std::int64_t for_each_leaf_node(const BoxNodes& nodes, const FloatBox& box, std::int32_t first,
                                           Visit&& visit) {
  struct Node {
    std::int32_t level, index;
  };
  std::array<Node, BoxNodes::most_levels * BoxLanes::width> stack;
  std::size_t size = 0;
  std::int64_t count = 0;
  stack[size++] = {nodes.height - 1, 0};
  while (size > 0) {
    const Node node = stack[--size];
    const BoxLanes& lanes = nodes.levels[node.level][node.index];
    const std::int32_t below = BoxLanes::width * node.index, first_below = first >> (3 * (node.level - 1));
    unsigned bits = overlapping(lanes, box);
    if (first_below > below) bits &= 0xffu << (first_below - below);
    for (; bits != 0; bits &= bits - 1) {
      const int lane = std::countr_zero(bits);
      if (node.level == 1) {
        ++count;
        visit(below + lane, lanes, lane);
      } else {
        stack[size++] = {node.level - 1, below + lane};
      }
    }
  }
  return count;
}

}  // namespace

void search_box(const BoxNodes& nodes, const FloatBox& box,
                void (*visit)(const void* context, std::int32_t node, unsigned lanes), const void* context) {
  const auto look = [&](std::int32_t node) {
    if (const unsigned bits = overlapping(nodes.levels[0][node], box); bits != 0) visit(context, node, bits);
  };
  if (nodes.height == 1) {
    look(0);
  } else if (nodes.height > 1) {
    for_each_leaf_node(nodes, box, 0, [&](std::int32_t node, const BoxLanes&, int) { look(node); });
  }
}

namespace {

/// Tests the moved lanes of node a against all leaves. Of two moved leaves, the one that comes first finds the other.
std::int64_t search_node(const BoxNodes& nodes, const MovedLeaves& moved, std::int32_t a) {
  BoxLanes own;
  for (unsigned bits = moved.lanes[a]; bits != 0; bits &= bits - 1) {
    const int lane = std::countr_zero(bits);
    const FloatBox box = nodes.levels[0][a].at(lane);
    own.set(lane, moved.margin > 0 ? box.enlarged(moved.margin) : box);
  }
  const auto look = [&](std::int32_t b, unsigned near) {
    const unsigned others = b < a ? ~unsigned{moved.lanes[b]} & 0xffu : 0xffu;
    std::uint64_t pairs = 0;
    for (near &= moved.lanes[a]; near != 0; near &= near - 1) {
      const int lane = std::countr_zero(near);
      unsigned bits = overlapping(nodes.levels[0][b], own.at(lane)) & others;
      if (b == a) bits &= ~unsigned{moved.lanes[a]} | (0xfeu << lane);
      pairs |= std::uint64_t{bits & 0xffu} << (BoxLanes::width * lane);
    }
    if (pairs != 0) moved.visit(moved.context, a, b, pairs);
  };
  if (nodes.height == 1) {
    look(a, 0xff);
    return 1;
  }
  return for_each_leaf_node(
      nodes, own.merged(), moved.all ? a : 0,
      [&](std::int32_t b, const BoxLanes& parent, int lane) { look(b, overlapping(own, parent.at(lane))); });
}

}  // namespace

/// Returns the number of tested pairs of nodes, and adds to `nodes_searched`. If all leaves have moved, each pair is
/// tested once and counts twice, as often as it would be tested otherwise.
std::int64_t search_moved(const BoxNodes& nodes, const MovedLeaves& moved, std::int64_t& nodes_searched) {
  std::int64_t work = 0;
  for (std::int32_t a = 0; a < nodes.leaf_nodes; ++a) {
    if (moved.lanes[a] == 0) continue;
    ++nodes_searched;
    work += search_node(nodes, moved, a);
  }
  return moved.all ? 2 * work : work;
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {

HWY_EXPORT(search_box);
HWY_EXPORT(search_moved);

namespace {

template <std::size_t n>
BoxNodes nodes_of(const std::array<std::vector<BoxLanes>, n>& levels, int height) {
  static_assert(n == BoxNodes::most_levels);
  BoxNodes nodes;
  for (int k = 0; k < height; ++k) nodes.levels[k] = levels[k].data();
  nodes.height = height;
  nodes.leaf_nodes = static_cast<std::int32_t>(levels[0].size());
  return nodes;
}

}  // namespace

void BodyTree::search(const FloatBox& box, VisitNode visit, const void* context) const {
  assert(fresh_);
  HWY_DYNAMIC_DISPATCH(search_box)(nodes_of(levels_, height_), box, visit, context);
}

void BodyTree::search_moved(double margin, VisitNodes visit, const void* context) {
  assert(fresh_);
  const MovedLeaves moved{moved_lanes_.data(), static_cast<std::int32_t>(moved_.size()) == size_, margin, visit,
                          context};
  std::int64_t nodes = 0;
  work_ = HWY_DYNAMIC_DISPATCH(search_moved)(nodes_of(levels_, height_), moved, nodes);
  account(nodes);
}

}  // namespace encage
#endif
