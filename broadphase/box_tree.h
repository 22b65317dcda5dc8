// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace encage {

/// Axis-aligned box in float32: small, for what only has to be conservative.
struct FloatBox {
  std::array<float, 3> lower{};
  std::array<float, 3> upper{};

  /// Contains the box enlarged by `margin` on every side, rounding of the sum included.
  /// What is NaN or beyond the range of float32 becomes infinite.
  static FloatBox around(const Eigen::AlignedBox3d& box, double margin = 0) noexcept;

  bool overlaps(const FloatBox& other) const noexcept {  // touching ones do
    return lower[0] <= other.upper[0] && other.lower[0] <= upper[0] && lower[1] <= other.upper[1] &&
           other.lower[1] <= upper[1] && lower[2] <= other.upper[2] && other.lower[2] <= upper[2];
  }
  bool contains(const FloatBox& other) const noexcept {
    return lower[0] <= other.lower[0] && other.upper[0] <= upper[0] && lower[1] <= other.lower[1] &&
           other.upper[1] <= upper[1] && lower[2] <= other.lower[2] && other.upper[2] <= upper[2];
  }
  FloatBox merged(const FloatBox& other) const noexcept;
  FloatBox enlarged(double margin) const noexcept;  ///< as around()
  friend bool operator==(const FloatBox&, const FloatBox&) = default;
};

/// Dynamic tree of boxes (Catto 2019, "Dynamic bounding volume hierarchies"): a leaf goes where
/// the surface-area heuristic finds it cheapest, rotations repair the path above it. The heights of
/// siblings differ by `max_imbalance` at most, so that a fixed stack holds every traversal.
///
/// Knows which leaves have moved since clear_moved(), and finds pairs for those alone.
/// The same calls give the same tree and the same order of visits. Concurrent
/// queries are safe while nothing changes the tree; queries never allocate.
class BoxTree {
 public:
  using Leaf = std::int32_t;

  static constexpr int max_imbalance = 4;
  /// A tree of height h has at least f(h) = f(h - 1) + f(h - 5) leaves: more than 2^31 for h = 90.
  static constexpr int max_height = 90;

  /// Adds a leaf with the caller's number for it; it has moved. On bad_alloc the tree is as before.
  Leaf insert(const FloatBox& box, std::uint32_t item);

  /// No work (and false) while `tight` stays in the leaf's box and that is not much larger than
  /// `fat`; otherwise the leaf moves to a new place with the box `fat`, which contains `tight`.
  bool update(Leaf leaf, const FloatBox& tight, const FloatBox& fat) noexcept;

  void remove(Leaf leaf) noexcept;

  /// Room for what the other tree holds: assigning it then allocates nothing, nor does update().
  void make_room_for(const BoxTree& other);

  /// Treats the leaf as moved.
  void touch(Leaf leaf) noexcept;
  bool has_moved(Leaf leaf) const noexcept { return nodes_[leaf].child[1] != none; }
  std::span<const Leaf> moved() const noexcept { return moved_; }
  void clear_moved() noexcept;

  const FloatBox& box(Leaf leaf) const noexcept { return nodes_[leaf].box; }
  std::uint32_t item(Leaf leaf) const noexcept { return static_cast<std::uint32_t>(nodes_[leaf].child[0]); }
  std::int32_t size() const noexcept { return size_; }
  int height() const noexcept { return root_ == none ? 0 : nodes_[root_].height; }

  /// Calls visit(item) for every leaf whose box overlaps `box`.
  template <class Visit>
  void query(const FloatBox& box, Visit&& visit) const {
    query_leaves(box, [&](Leaf leaf) { visit(item(leaf)); });
  }

  /// Calls visit(item, other item) once for every two leaves of which one has moved and whose
  /// boxes, one of them enlarged by `margin`, overlap. For one leaf that has moved after the other.
  template <class Visit>
  void query_moved_pairs(double margin, Visit&& visit) const {
    for (const Leaf leaf : moved_) {
      query_leaves(nodes_[leaf].box.enlarged(margin), [&](Leaf other) {
        // Two moved leaves meet twice.
        if (other != leaf && !(has_moved(other) && other < leaf)) visit(item(leaf), item(other));
      });
    }
  }

  /// Sum of the nodes' surface areas over that of the root: about how many nodes a small query visits.
  double cost() const noexcept;

  /// What is wrong with the structure, for tests; empty if nothing is.
  std::string defect() const;

 private:
  static constexpr std::int32_t none = -1;

  struct Node {
    FloatBox box;
    std::int32_t parent = none;  // of free nodes: the next one
    // Of leaves: the item, and the position in moved_ or none.
    std::array<std::int32_t, 2> child{none, none};
    std::int32_t height = 0;  // of leaves 0, of free nodes none
  };
  // Exchange of a child with a child of its sibling.
  struct Rotation {
    std::int32_t sinking = none;
    std::int32_t rising = none;
    double cost = 0;
  };

  template <class Visit>
  void query_leaves(const FloatBox& box, Visit&& visit) const {
    if (root_ == none) return;
    std::array<std::int32_t, max_height + 2> stack;
    int size = 0;
    stack[size++] = root_;
    while (size > 0) {
      const std::int32_t n = stack[--size];
      const Node& node = nodes_[n];
      if (!node.box.overlaps(box)) continue;
      if (node.height == 0) {
        visit(n);
        continue;
      }
      assert(size <= max_height);
      stack[size++] = node.child[1];
      stack[size++] = node.child[0];
    }
  }

  std::int32_t take_node() noexcept;
  void free_node(std::int32_t n) noexcept;
  std::int32_t best_sibling(const FloatBox& box) const noexcept;
  void link(Leaf leaf) noexcept;
  void unlink(Leaf leaf) noexcept;
  void repair_upwards(std::int32_t n) noexcept;
  void rotate(std::int32_t n) noexcept;
  void refit(std::int32_t n) noexcept;
  void replace_child(std::int32_t parent, std::int32_t old_child, std::int32_t new_child) noexcept;
  Rotation best_rotation(std::int32_t n, int old_height) const noexcept;
  std::string node_defect(std::int32_t n) const;

  std::vector<Node> nodes_;
  std::vector<Leaf> moved_;
  std::int32_t root_ = none;
  std::int32_t free_ = none;
  std::int32_t size_ = 0;
};

}  // namespace encage
