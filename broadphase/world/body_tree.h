// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace encage {

/// Axis-aligned box in float32: small, and accurate enough for conservative tests.
struct FloatBox {
  std::array<float, 3> lower{};
  std::array<float, 3> upper{};

  /// Returns a box that contains the given box enlarged by `margin` on every side, rounding of the sum included. Bounds
  /// that are NaN or beyond the range of float32 become infinite.
  static FloatBox around(const Eigen::AlignedBox3d& box, double margin = 0) noexcept;

  bool overlaps(const FloatBox& other) const noexcept {  // boxes that touch do
    return lower[0] <= other.upper[0] && other.lower[0] <= upper[0] && lower[1] <= other.upper[1] &&
           other.lower[1] <= upper[1] && lower[2] <= other.upper[2] && other.lower[2] <= upper[2];
  }
  bool contains(const FloatBox& other) const noexcept {
    return lower[0] <= other.lower[0] && other.upper[0] <= upper[0] && lower[1] <= other.lower[1] &&
           other.upper[1] <= upper[1] && lower[2] <= other.lower[2] && other.upper[2] <= upper[2];
  }
  FloatBox merged(const FloatBox& other) const noexcept;
  FloatBox enlarged(double margin) const noexcept;  ///< rounded as in around()
  friend bool operator==(const FloatBox&, const FloatBox&) = default;
};

/// Eight boxes, for eight comparisons at once.
struct alignas(64) BoxLanes {
  static constexpr int width = 8;
  std::array<std::array<float, width>, 3> lower{}, upper{};

  BoxLanes() noexcept;  ///< all empty
  void set(int lane, const FloatBox& box) noexcept {
    for (int k = 0; k < 3; ++k) {
      lower[k][lane] = box.lower[k];
      upper[k][lane] = box.upper[k];
    }
  }
  void clear(int lane) noexcept { set(lane, empty_box()); }
  bool is_empty(int lane) const noexcept { return std::isnan(lower[0][lane]); }
  FloatBox at(int lane) const noexcept {
    FloatBox box;
    for (int k = 0; k < 3; ++k) {
      box.lower[k] = lower[k][lane];
      box.upper[k] = upper[k][lane];
    }
    return box;
  }
  FloatBox merged() const noexcept;

 private:
  /// All bounds are NaN: the box is neutral when merged, and apart from every box.
  static FloatBox empty_box() noexcept;
};

/// Packed tree of boxes, eight wide and without pointers: child k of node n is node 8 n + k of the level below (Kamel
/// and Faloutsos 1993, "On packing R-trees"). Leaves are ordered by splitting them at medians (Bentley 1975,
/// "Multidimensional binary search trees used for associative searching"). Where leaves move, the boxes of their nodes
/// follow; leaves are ordered again after some have been added, or when boxes that grew have cost searches as much time
/// as ordering takes.
///
/// The tree records which leaves have moved since clear_moved(), and finds pairs for those alone. The same calls give
/// the same tree and the same order of visits. Changes take effect at refresh(), which must come before searches,
/// except for query_in_order(). Concurrent queries are safe while nothing changes the tree; only insert() allocates.
class BodyTree {
 public:
  using Leaf = std::int32_t;

  /// Adds a leaf with the caller's number for it; the leaf counts as moved. On bad_alloc the tree is unchanged.
  Leaf insert(const FloatBox& box, std::uint32_t item);

  /// Sets the box of a leaf, which counts as moved.
  void update(Leaf leaf, const FloatBox& box) noexcept;

  void remove(Leaf leaf) noexcept;

  /// Reserves capacity for the content of the other tree: assigning it then allocates nothing, nor do changes but
  /// insert().
  void make_room_for(const BodyTree& other);

  /// Treats the leaf as moved.
  void touch(Leaf leaf) noexcept;
  bool has_moved(Leaf leaf) const noexcept { return leaves_[leaf].moved != none; }
  std::span<const Leaf> moved() const noexcept { return moved_; }
  void clear_moved() noexcept;
  /// Returns the leaves that have changed since refresh(): the nodes do not know them as they are.
  std::span<const Leaf> stale() const noexcept { return moved().subspan(static_cast<std::size_t>(placed_)); }
  bool is_stale(Leaf leaf) const noexcept { return leaves_[leaf].moved >= placed_; }

  const FloatBox& box(Leaf leaf) const noexcept { return leaves_[leaf].box; }
  std::uint32_t item(Leaf leaf) const noexcept { return leaves_[leaf].item; }
  std::int32_t size() const noexcept { return size_; }

  /// Brings the nodes up to date.
  void refresh() noexcept;

  /// Calls visit(item) for every leaf whose box overlaps `box`. The tree must be refreshed.
  template <class Visit>
  void query(const FloatBox& box, Visit&& visit) const {
    const auto each = [&](std::int32_t node, unsigned lanes) {
      for (; lanes != 0; lanes &= lanes - 1) {
        visit(items_[BoxLanes::width * node + std::countr_zero(lanes)]);
      }
    };
    search(box, call<decltype(each), std::int32_t, unsigned>, &each);
  }

  /// Calls visit(item, other item) once for every two leaves of which one has moved and whose boxes overlap, or overlap
  /// once either of them is enlarged by `margin`. It may leave out two leaves that overlap only if one particular box
  /// of the two is enlarged. The tree must be refreshed.
  template <class Visit>
  void query_moved_pairs(double margin, Visit&& visit) {
    const auto each = [&](std::int32_t a, std::int32_t b, std::uint64_t lanes) {
      for (; lanes != 0; lanes &= lanes - 1) {
        const int bit = std::countr_zero(lanes);
        visit(items_[BoxLanes::width * a + bit / BoxLanes::width], items_[BoxLanes::width * b + bit % BoxLanes::width]);
      }
    };
    search_moved(margin, call<decltype(each), std::int32_t, std::int32_t, std::uint64_t>, &each);
  }

  /// Calls visit(item) for the leaves, except stale() ones, whose keys do not exceed bound() when their turn comes; of
  /// the children of a node those with less keys come first. keys(lanes) returns the keys of eight boxes, NaN for those
  /// to leave out. The key of a box must not exceed those of boxes in it.
  template <class Keys, class Bound, class Visit>
  void query_in_order(const Keys& keys, const Bound& bound, Visit&& visit) const {
    struct Step {
      double key;
      std::int32_t level, index;  // the level of a leaf is -1
    };
    std::array<Step, most_levels * BoxLanes::width> stack;
    std::size_t size = 0;
    if (height_ > 0) stack[size++] = {-infinite, height_ - 1, 0};
    while (size > 0) {
      const Step step = stack[--size];
      if (step.key > bound()) continue;
      if (step.level < 0) {
        visit(items_[static_cast<std::size_t>(step.index)]);
        continue;
      }
      const BoxLanes& lanes = levels_[static_cast<std::size_t>(step.level)][static_cast<std::size_t>(step.index)];
      const std::array<double, BoxLanes::width> near = keys(lanes);
      const std::size_t first = size;
      for (int lane = 0; lane < BoxLanes::width; ++lane) {
        const std::int32_t index = BoxLanes::width * step.index + lane;
        if (!(near[lane] <= bound()) || lanes.is_empty(lane)) continue;
        if (step.level == 0 && is_stale(order_[static_cast<std::size_t>(index)])) continue;
        std::size_t place = size++;
        for (; place > first && stack[place - 1].key < near[lane]; --place) stack[place] = stack[place - 1];
        stack[place] = {near[lane], step.level - 1, index};
      }
    }
  }

  /// For tests: describes a defect of the structure; empty if there is none.
  std::string defect() const;
  /// Number of pairs of nodes that the last query_moved_pairs() tested.
  std::int64_t work() const noexcept { return work_; }

 private:
  static constexpr std::int32_t none = -1;
  static constexpr int most_levels = 11;  // 8^11 > 2^31

  struct Entry {
    FloatBox box;
    std::uint32_t item = 0;
    std::int32_t slot = none;   // of a free entry: the next one
    std::int32_t moved = none;  // position in moved_
  };
  // A leaf during ordering.
  struct Centre {
    std::array<float, 3> at;
    Leaf leaf;
  };
  using VisitNode = void (*)(const void* context, std::int32_t node, unsigned lanes);
  using VisitNodes = void (*)(const void* context, std::int32_t a, std::int32_t b, std::uint64_t lanes);

  template <class Function, class... Arguments>
  static void call(const void* function, Arguments... arguments) {
    (*static_cast<const Function*>(function))(arguments...);
  }

  std::int32_t slots() const noexcept { return static_cast<std::int32_t>(order_.size()); }
  void search(const FloatBox& box, VisitNode visit, const void* context) const;
  void search_moved(double margin, VisitNodes visit, const void* context);
  void account(std::int64_t nodes) noexcept;
  void make_stale(Leaf leaf) noexcept;

  void make_room_for(std::size_t slots, std::size_t leaves);
  bool is_worn() const noexcept;
  void order_leaves() noexcept;
  void split(std::size_t first, std::size_t last) noexcept;
  void resize_levels() noexcept;
  void place_leaves(bool all) noexcept;
  void refit() noexcept;

  std::vector<Entry> leaves_;                                 // indexed by Leaf
  std::vector<Leaf> moved_;                                   // first those that the nodes know as they are
  std::vector<Leaf> order_;                                   // indexed by slot; none if empty
  std::vector<std::uint32_t> items_;                          // indexed by slot
  std::array<std::vector<BoxLanes>, most_levels> levels_;     // level 0 has the slots
  std::array<std::vector<std::uint8_t>, most_levels> dirty_;  // 1 for nodes of which a lane has changed
  std::vector<std::uint8_t> moved_lanes_;                     // bits of the moved lanes, for the nodes of level 0
  std::vector<Centre> centres_;
  int height_ = 0;  // levels in use
  std::int32_t free_ = none;
  std::int32_t size_ = 0;
  std::int32_t placed_ = 0;  // how many of moved_ the nodes know
  bool fresh_ = true;

  std::int32_t loose_ = 0;  // number of leaves added since the others were ordered
  std::int64_t work_ = 0;
  double least_rate_ = infinite;  // of work per searching node, since then
  double lost_ = 0;               // work above that rate
  static constexpr double infinite = std::numeric_limits<double>::infinity();
};

}  // namespace encage
