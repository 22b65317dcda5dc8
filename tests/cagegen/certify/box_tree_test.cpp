// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/box_tree.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace encage::proof {
namespace {

/// Every triangle in one leaf, every box inside that of its parent and around its triangles.
void expect_valid(const BoxTree& tree, const TriangleMesh& mesh) {
  std::vector<int> seen(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const BoxTree::Node& node = tree.nodes[n];
    if (node.count == 0) {
      ASSERT_GT(node.first, static_cast<std::int32_t>(n));
      ASSERT_LT(node.first + 1, static_cast<std::int32_t>(tree.nodes.size()));
      for (int child = 0; child < 2; ++child) {
        for (int k = 0; k < 3; ++k) {
          EXPECT_LE(node.low[k], tree.nodes[node.first + child].low[k]);
          EXPECT_GE(node.high[k], tree.nodes[node.first + child].high[k]);
        }
      }
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      ++seen[tree.order[i]];
      for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < 3; ++k) {
          EXPECT_LE(node.low[k], mesh.corner(tree.order[i], c)[k]);
          EXPECT_GE(node.high[k], mesh.corner(tree.order[i], c)[k]);
        }
      }
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), mesh.triangles.rows());
}

TEST(BoxTree, HoldsEveryTriangleOnce) {
  expect_valid(BoxTree(shapes::tetrahedron(1)), shapes::tetrahedron(1));
  expect_valid(BoxTree(shapes::sphere(4)), shapes::sphere(4));
}

TEST(BoxTree, EqualCentroidsAreSplitByIndex) {
  TriangleMesh pile = shapes::tetrahedron(1);
  pile.triangles = pile.triangles.row(0).replicate(1000, 1).eval();
  const BoxTree tree(pile);
  expect_valid(tree, pile);
  EXPECT_TRUE(std::is_sorted(tree.order.begin(), tree.order.end()));
}

}  // namespace
}  // namespace encage::proof
