// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/kdop_tree.h"

#include "tests/bench/tank/swept_meshes.h"

#include <gtest/gtest.h>

namespace encage::tank {
namespace {

TEST(KdopTree, ReportsOverlappingPolytopesOfTriangles) {
  KdopTree a, b;
  test::expect_brute_force(a, b, Kdop::pairs);
}

TEST(KdopTree, CoincidentTriangles) {
  KdopTree a, b;
  test::expect_coincident_triangles(a, b);
}

TEST(KdopTree, EmptyMesh) {
  KdopTree a, b;
  test::expect_nothing_of_an_empty_mesh(a, b);
}

TEST(KdopTree, RejectsMoreThanBoxes) {
  // Two needles along parallel space diagonals: their boxes overlap, their 26-DOPs do not.
  TriangleMesh needle;
  needle.vertices.resize(3, 3);
  needle.vertices << 0, 0, 0, 1, 1, 1, 0.5, 0.5, 0.51;
  needle.triangles.resize(1, 3);
  needle.triangles << 0, 1, 2;
  Motion beside;
  beside.start.translation() = beside.end.translation() = Eigen::Vector3d(0.3, 0, 0);
  const BodyMesh body(needle, Eigen::Vector3d::Zero());
  const Sweep a = make_sweep(body, {}, 0);
  const Sweep b = make_sweep(body, beside, 0);
  ASSERT_LT(test::gap(a, 0, b, 0, 3), 0);
  KdopTree tree_a, tree_b;
  tree_a.build(a);
  tree_b.build(b);
  std::vector<TrianglePair> pairs;
  KdopTree::overlaps(tree_a, tree_b, pairs);
  EXPECT_TRUE(pairs.empty());
}

}  // namespace
}  // namespace encage::tank
