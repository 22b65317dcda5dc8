// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/tree/refit.h"

#include "oracles/meshes.h"
#include "src/tree/mesh_arrays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace encage {
namespace {

/// Two tori and triangles that share no vertices, some of them degenerate.
TriangleMesh many_parts() {
  shapes::Random random(7);
  TriangleMesh mesh =
      shapes::joined(shapes::torus(1, 0.35, 40, 20), shapes::moved(shapes::torus(0.5, 0.1, 30, 10), {1.5, 0, 0.25}));
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d at = random.point(2);
    mesh = shapes::with_triangle(mesh, at, at + 0.1 * random.point(1),
                                 i % 7 == 0 ? at : Eigen::Vector3d(at + 0.1 * random.point(1)));
  }
  return mesh;
}

MeshArrays arrays_of(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return make_mesh_arrays(mesh, "mesh");
}

std::size_t slabs(const MeshTree& tree) {
  std::size_t count = 0;
  for (const MeshNode& node : tree.nodes) {
    for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
      count += node.normal[0][lane] != 0 || node.normal[1][lane] != 0 || node.normal[2][lane] != 0;
    }
  }
  return count;
}

TEST(RefitTree, ContainsTrianglesWhereverTheirVerticesAre) {
  shapes::Random random(3);
  for (const double factor : {1.0, 1e-30, 1e30}) {
    for (const double bend : {0.0, 1e-6, 0.05, 0.5, 10.0}) {
      SCOPED_TRACE(testing::Message() << "factor " << factor << ", bend " << bend);
      MeshArrays arrays = arrays_of(many_parts());
      const MeshTree before = arrays.tree;
      for (auto& vertex : arrays.vertices) {
        const Eigen::Vector3d by = bend * random.point(1);
        for (std::size_t k = 0; k < 3; ++k) {
          vertex[k] = static_cast<float>(factor * (static_cast<double>(vertex[k]) + by[static_cast<int>(k)]));
        }
      }
      refit_tree(arrays.tree, {arrays.vertices, arrays.triangles});
      EXPECT_NO_THROW(check_bounds(arrays.tree, {arrays.vertices, arrays.triangles}, "tree"));
      for (std::size_t n = 0; n < before.nodes.size(); ++n) {
        for (int lane = 0; lane < MeshNode::width; ++lane) {
          EXPECT_EQ(arrays.tree.nodes[n].link[lane], before.nodes[n].link[lane]);
        }
      }
      if (bend == 0 && factor == 1) {
        // Boxes are as tight as those of a new tree.
        for (std::size_t n = 0; n < before.nodes.size(); ++n) {
          for (int lane = 0; lane < MeshNode::width; ++lane) {
            for (int axis = 0; axis < 3; ++axis) {
              EXPECT_EQ(arrays.tree.nodes[n].lower[axis][lane], before.nodes[n].lower[axis][lane]);
              EXPECT_EQ(arrays.tree.nodes[n].upper[axis][lane], before.nodes[n].upper[axis][lane]);
            }
          }
        }
        EXPECT_GT(slabs(arrays.tree), slabs(before) * 9 / 10);
      }
    }
  }
}

TEST(RefitTree, SlabsFollowATurn) {
  // A flat sheet that is turned out of its plane stays in thin slabs.
  const int n = 40;
  std::vector<std::array<double, 3>> vertices;
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) vertices.push_back({i / 64.0, j / 64.0, 0});
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int v = i * (n + 1) + j;
      triangles.push_back({v, v + n + 1, v + 1});
      triangles.push_back({v + 1, v + n + 1, v + n + 2});
    }
  }
  MeshArrays arrays = arrays_of(shapes::mesh(vertices, triangles));
  const double turn = 0.7;
  for (auto& vertex : arrays.vertices) {
    vertex[2] = static_cast<float>(std::sin(turn) * static_cast<double>(vertex[0]));
    vertex[0] = static_cast<float>(std::cos(turn) * static_cast<double>(vertex[0]));
  }
  refit_tree(arrays.tree, {arrays.vertices, arrays.triangles});
  EXPECT_NO_THROW(check_bounds(arrays.tree, {arrays.vertices, arrays.triangles}, "tree"));
  for (const MeshNode& node : arrays.tree.nodes) {
    for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
      if (node.count(lane) == MeshNode::inner) continue;
      EXPECT_LT(node.slab_upper[lane] - node.slab_lower[lane], 200);
    }
  }
}

}  // namespace
}  // namespace encage
