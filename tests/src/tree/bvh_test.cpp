// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/tree/bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace encage {
namespace {

TriangleMesh soup(int triangles, unsigned seed) {
  std::minstd_rand random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  TriangleMesh mesh;
  mesh.vertices.resize(3 * triangles, 3);
  mesh.triangles.resize(triangles, 3);
  for (int t = 0; t < triangles; ++t) {
    const Eigen::Vector3d centre(uniform(random), uniform(random), uniform(random));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d(uniform(random), uniform(random), uniform(random));
      mesh.vertices.row(3 * t + k) = (centre + 0.05 * d).transpose();
      mesh.triangles(t, k) = 3 * t + k;
    }
  }
  return mesh;
}

/// Checks that every node's box contains everything below it, that leaves partition the triangles, and that depth and
/// sizes keep their limits.
void expect_valid(const TriangleMesh& mesh, const Bvh& tree) {
  struct Visit {
    std::int32_t node;
    int depth;
  };
  std::vector<Visit> stack{{0, 0}};
  std::vector<int> visits(tree.nodes.size(), 0), held(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const BvhNode& node = tree.nodes[visit.node];
    ++visits[visit.node];
    ASSERT_LE(visit.depth, Bvh::max_depth);
    if (node.leaf()) {
      ASSERT_LE(node.count, Bvh::leaf_size);
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        ++held[tree.order[i]];
        for (int k = 0; k < 3; ++k) {
          for (int axis = 0; axis < 3; ++axis) {
            ASSERT_LE(static_cast<double>(node.lower[axis]), mesh.corner(tree.order[i], k)[axis]);
            ASSERT_GE(static_cast<double>(node.upper[axis]), mesh.corner(tree.order[i], k)[axis]);
          }
        }
      }
      continue;
    }
    for (const std::int32_t child : {node.first, node.first + 1}) {
      ASSERT_GT(child, visit.node);
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_LE(node.lower[axis], tree.nodes[child].lower[axis]);
        ASSERT_GE(node.upper[axis], tree.nodes[child].upper[axis]);
      }
      stack.push_back({child, visit.depth + 1});
    }
  }
  EXPECT_EQ(std::count(visits.begin(), visits.end(), 1), static_cast<std::ptrdiff_t>(visits.size()));
  EXPECT_EQ(std::count(held.begin(), held.end(), 1), static_cast<std::ptrdiff_t>(held.size()));
}

TEST(Bvh, HoldsEveryTriangleOnce) {
  for (const int n : {1, 2, 4, 5, 17, 1000, 20'000}) {
    const TriangleMesh mesh = soup(n, 1);
    expect_valid(mesh, build_bvh(mesh));
  }
  EXPECT_TRUE(build_bvh(TriangleMesh{}).nodes.empty());
}

TEST(Bvh, EqualAndCollinearCentresKeepTheDepthBound) {
  TriangleMesh same = soup(1, 2);
  same.triangles = same.triangles.replicate(3000, 1).eval();
  expect_valid(same, build_bvh(same));
  // Each triangle is twice as far as the one before: the heuristic alone would split off one at a time.
  TriangleMesh growing = soup(120, 3);
  for (int t = 0; t < 120; ++t) growing.vertices.middleRows(3 * t, 3) *= std::ldexp(1.0, t - 60);
  expect_valid(growing, build_bvh(growing));
}

TEST(Bvh, RoundsOutward) {
  TriangleMesh mesh = soup(200, 4);
  mesh.vertices.array() += 1e6;  // far more digits than float can represent
  expect_valid(mesh, build_bvh(mesh));
}

TEST(Bvh, SameMeshSameTree) {
  const TriangleMesh mesh = soup(5000, 5);
  const Bvh a = build_bvh(mesh), b = build_bvh(mesh);
  EXPECT_EQ(a.order, b.order);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].first, b.nodes[i].first);
    EXPECT_EQ(a.nodes[i].count, b.nodes[i].count);
    EXPECT_TRUE(std::equal(a.nodes[i].lower, a.nodes[i].lower + 3, b.nodes[i].lower));
    EXPECT_TRUE(std::equal(a.nodes[i].upper, a.nodes[i].upper + 3, b.nodes[i].upper));
  }
}

}  // namespace
}  // namespace encage
