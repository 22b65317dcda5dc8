// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/kdop.h"
#include "bench/tank/sweep.h"

#include <encage/separated.h>

#include <cstdint>
#include <vector>

namespace encage::tank {

/// The paper's bounding volume hierarchy (section 4, collision detection): a binary tree of 26-DOPs over the swept
/// triangles of one step, for candidates of the continuous narrow phase. The paper does not say how it is built; this
/// is the classical fast way: top-down, a node is split at the mean of its triangles' centres along the longest side of
/// their box, and the volumes are merged from the leaves up. One thread.
class KdopTree {
 public:
  static constexpr int leaf_size = 4;  ///< triangles in a leaf, at most

  /// Forgets what was there; keeps the memory, so that building again is cheaper.
  void build(const Sweep& sweep);

  /// Appends all pairs of triangles whose 26-DOPs overlap, in the order of the traversal.
  static void overlaps(const KdopTree& a, const KdopTree& b, std::vector<TrianglePair>& pairs);

 private:
  struct DopNode {
    Kdop dop;
    std::int32_t first;  ///< leaf: first entry of order_; inner node: the right child, the left one being the next node
    std::int32_t count;  ///< leaf: number of triangles; inner node: 0
  };
  struct Centre {
    std::array<float, 3> at;
    std::int32_t triangle;
  };

  Kdop triangle_dop(std::int32_t triangle) const;
  void build_node(std::int32_t begin, std::int32_t end, int depth);
  std::int32_t partition(std::int32_t begin, std::int32_t end, int depth);
  void merge_from_leaves();
  static void leaf_overlaps(const KdopTree& a, const DopNode& leaf_a, const KdopTree& b, const DopNode& leaf_b,
                            std::vector<TrianglePair>& pairs);

  const Triangles* triangles_ = nullptr;
  std::vector<Kdop> vertices_;
  std::vector<Centre> order_;
  std::vector<DopNode> nodes_;
};

}  // namespace encage::tank
