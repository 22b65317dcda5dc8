// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/tree/mesh_tree.h"

#include "oracles/meshes.h"
#include "src/tree/mesh_arrays.h"
#include "tests/src/asset/forge.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace encage {
namespace {

TriangleMesh rounded_mesh(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

/// Triangles that share no vertices; some are degenerate, some repeated.
TriangleMesh tree_soup(int triangles, std::uint32_t seed) {
  shapes::Random random(seed);
  TriangleMesh mesh;
  mesh.vertices.resize(3 * triangles, 3);
  mesh.triangles.resize(triangles, 3);
  for (int t = 0; t < triangles; ++t) {
    const Eigen::Vector3d centre = random.point(1);
    const int kind = random.integer(8);
    for (int k = 0; k < 3; ++k) {
      mesh.vertices.row(3 * t + k) = (centre + (kind == 0 ? 0 : 0.05) * random.point(1)).transpose();
      mesh.triangles(t, k) = 3 * t + k;
    }
    if (kind == 1) mesh.triangles(t, 2) = mesh.triangles(t, 1);
    if (kind == 2 && t > 0) mesh.triangles.row(t) = mesh.triangles.row(random.integer(t)).eval();
  }
  return rounded_mesh(mesh);
}

TriangleMesh coincident(int triangles) {
  TriangleMesh mesh = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}}, {});
  mesh.triangles.resize(triangles, 3);
  for (int t = 0; t < triangles; ++t) mesh.triangles.row(t) << 0, 1, 2;
  return mesh;
}

/// Sizes that shrink by a factor from one triangle to the next: splits by area separate one at a time.
TriangleMesh geometric(int triangles) {
  TriangleMesh mesh;
  mesh.vertices.resize(3 * triangles, 3);
  mesh.triangles.resize(triangles, 3);
  for (int t = 0; t < triangles; ++t) {
    const double x = std::pow(0.75, t);
    mesh.vertices.row(3 * t) << x, 0, 0;
    mesh.vertices.row(3 * t + 1) << x, 0.1 * x, 0;
    mesh.vertices.row(3 * t + 2) << x, 0, 0.1 * x;
    mesh.triangles.row(t) << 3 * t, 3 * t + 1, 3 * t + 2;
  }
  return rounded_mesh(mesh);
}

std::vector<std::pair<std::string, TriangleMesh>> tree_meshes() {
  return {{"one triangle", coincident(1)},
          {"two triangles", coincident(2)},
          {"three triangles", tree_soup(3, 1)},
          {"a point", rounded_mesh(shapes::mesh({{1, 2, 3}}, {{0, 0, 0}}))},
          {"soup of 17", tree_soup(17, 2)},
          {"soup of 1000", tree_soup(1000, 3)},
          {"soup of 20000", tree_soup(20'000, 4)},
          {"flat", shapes::box({-1, -1, 0}, {1, 1, 0})},
          {"sphere", rounded_mesh(shapes::sphere(4))},
          {"torus", rounded_mesh(shapes::torus(1, 0.3, 40, 20))},
          {"tiny", rounded_mesh(shapes::scaled(shapes::sphere(2), 1e-30))},
          {"huge", rounded_mesh(shapes::scaled(shapes::sphere(2), 1e38))},
          {"geometric", geometric(300)},
          {"coincident", coincident(10'000)}};
}

/// Checks the properties that a traversal needs, by a recursion of its own.
class Walk {
 public:
  Walk(const MeshTree& tree, const TriangleMesh& mesh)
      : tree_(tree), mesh_(mesh), nodes(tree.nodes.size(), 0), leaves(tree.leaves.size(), 0) {
    visit(0, 0);
  }
  int deepest = 0;
  std::int64_t lanes = 0;

 private:
  using Box = Eigen::AlignedBox3d;
  /// Returns the tight box around everything below a node.
  Box visit(std::int32_t n, int depth) {
    deepest = std::max(deepest, depth);
    ++nodes[n];
    const MeshNode& node = tree_.nodes[n];
    Box all;
    bool ended = false;
    for (int lane = 0; lane < MeshNode::width; ++lane) {
      const int count = node.count(lane);
      if (count == MeshNode::unused) {
        ended = true;
        continue;
      }
      EXPECT_FALSE(ended) << "a gap in node " << n;
      ++lanes;
      Box below;
      if (count == MeshNode::inner) {
        EXPECT_GT(node.child(lane), n);
        below = visit(node.child(lane), depth + 1);
      } else {
        EXPECT_LE(count, MeshTree::leaf_size);
        for (std::int32_t i = node.child(lane); i < node.child(lane) + count; ++i) {
          ++leaves[i];
          for (const std::int32_t v : tree_.leaves[i].vertices) below.extend(mesh_.vertex(v));
        }
      }
      for (int axis = 0; axis < 3; ++axis) {
        // The bound is the next grid coordinate, or one more where the coordinates are rounded_mesh.
        const auto low = static_cast<double>(view_.lower(node, axis, lane));
        const auto high = static_cast<double>(view_.upper(node, axis, lane));
        const double reach = 2.001 * static_cast<double>(tree_.grid.step);
        EXPECT_LE(low, below.min()[axis]) << n << " " << lane;
        EXPECT_GE(low, below.min()[axis] - reach) << n << " " << lane;
        EXPECT_GE(high, below.max()[axis]) << n << " " << lane;
        EXPECT_LE(high, below.max()[axis] + reach) << n << " " << lane;
      }
      all.extend(below);
    }
    return all;
  }

  const MeshTree& tree_;
  const TriangleMesh& mesh_;
  const MeshTreeView view_{tree_};

 public:
  std::vector<int> nodes, leaves;
};

TEST(MeshTree, EveryTriangleInOneLeafAndTightBoxes) {
  for (const auto& [name, mesh] : tree_meshes()) {
    SCOPED_TRACE(name);
    const MeshTree tree = build_mesh_tree(mesh);
    const Walk walk(tree, mesh);
    EXPECT_EQ(std::count(walk.nodes.begin(), walk.nodes.end(), 1), std::ssize(tree.nodes));
    EXPECT_EQ(std::count(walk.leaves.begin(), walk.leaves.end(), 1), std::ssize(tree.leaves));
    EXPECT_LE(walk.deepest, MeshTree::max_depth);
    std::vector<int> seen(static_cast<std::size_t>(mesh.triangles.rows()), 0);
    for (const LeafTriangle& leaf : tree.leaves) {
      ++seen[leaf.triangle];
      for (int k = 0; k < 3; ++k) EXPECT_EQ(leaf.vertices[k], mesh.triangles(leaf.triangle, k));
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), mesh.triangles.rows());
    const MeshArrays arrays = make_mesh_arrays(mesh, "mesh");
    EXPECT_NO_THROW(check_bounds(tree, {arrays.vertices, arrays.triangles}, "mesh"));
  }
}

TEST(MeshTree, NodesAreWellFilledAndShallow) {
  const TriangleMesh mesh = tree_soup(20'000, 4);
  const MeshTree tree = build_mesh_tree(mesh);
  const Walk walk(tree, mesh);
  EXPECT_GT(walk.lanes, 3 * std::ssize(tree.nodes));
  EXPECT_LE(walk.deepest, 12);
}

TEST(MeshTree, IsEmptyForNothingAndTheSameTwice) {
  EXPECT_TRUE(build_mesh_tree({}).nodes.empty());
  for (const auto& [name, mesh] : tree_meshes()) {
    const MeshTree first = build_mesh_tree(mesh), second = build_mesh_tree(mesh);
    ASSERT_EQ(first.nodes.size(), second.nodes.size()) << name;
    ASSERT_EQ(first.leaves.size(), second.leaves.size()) << name;
    EXPECT_EQ(std::memcmp(first.nodes.data(), second.nodes.data(), first.nodes.size() * sizeof(MeshNode)), 0) << name;
    EXPECT_EQ(std::memcmp(first.leaves.data(), second.leaves.data(), first.leaves.size() * sizeof(LeafTriangle)), 0)
        << name;
  }
}

TEST(TreeGrid, CoversTheVerticesInStepsThatIncrease) {
  shapes::Random random(9);
  for (int round = 0; round < 300; ++round) {
    const auto size = static_cast<float>(std::pow(10.0, random(-40, 37)));
    const auto offset = static_cast<float>(std::pow(10.0, random(-8, 8)) * random.integer(2));
    std::vector<std::array<float, 3>> vertices;
    float low = std::numeric_limits<float>::infinity(), high = -low;
    for (int v = 0; v < 1 + random.integer(20); ++v) {
      const float x = size * (offset + static_cast<float>(random(-1, 1)));
      if (!std::isfinite(x)) continue;
      vertices.push_back({x, x, -x});
      low = std::min(low, x);
      high = std::max(high, x);
    }
    const TreeGrid grid = make_grid(vertices);
    if (vertices.empty()) continue;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_LE(grid.at(axis, -32768), axis < 2 ? low : -high);
      EXPECT_GE(grid.at(axis, 32767), axis < 2 ? high : -low);
      EXPECT_GT(grid.step, 0);
      for (int i = 0; i < 50; ++i) {
        const int coordinate = random.integer(65535) - 32768;
        EXPECT_LT(grid.at(axis, static_cast<std::int16_t>(coordinate)),
                  grid.at(axis, static_cast<std::int16_t>(coordinate + 1)))
            << size << " " << offset << " " << coordinate;
      }
    }
  }
}

// ---- Damage ----------------------------------------------------------------

/// Returns the message for a tree that `spoil` damaged; the mesh is a sphere of 512 triangles.
std::string refusal(const std::function<void(MeshTree&)>& spoil) {
  static const MeshArrays arrays = make_mesh_arrays(rounded_mesh(shapes::sphere(3)), "m");
  MeshTree tree = arrays.tree;
  spoil(tree);
  return error_of([&] { check_bounds(tree, {arrays.vertices, arrays.triangles}, "m"); });
}

/// Node and lane of the first leaf, or of the first lane with a child.
std::pair<std::size_t, int> find_lane(const MeshTree& tree, bool leaf, int skip = 0) {
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    for (int lane = 0; lane < MeshNode::width; ++lane) {
      const int count = tree.nodes[n].count(lane);
      if (count != MeshNode::unused && (count > 0) == leaf && skip-- == 0) return {n, lane};
    }
  }
  throw std::runtime_error("no such lane");
}

std::string node(std::size_t n) { return "m: node " + std::to_string(n) + " "; }

constexpr std::int32_t last_index = (1 << 29) - 1;  // the largest index that a link can store

TEST(CheckTree, RefusesDamagedLinks) {
  const auto link = [](std::int32_t child) {
    return [child](MeshTree& t) { t.nodes[0].set_link(0, child, MeshNode::inner); };
  };
  EXPECT_EQ(refusal(link(0)), node(0) + "has a child that is not after it");  // makes a cycle
  EXPECT_EQ(refusal(link(last_index)), node(0) + "has a child that is not after it");
  EXPECT_EQ(refusal([](MeshTree& t) { t.nodes.pop_back(); }).substr(0, 7), "m: node");
  EXPECT_EQ(refusal([](MeshTree& t) { t.nodes[0].link[1] = t.nodes[0].link[0]; }), node(1) + "has two parents");
  // A child precedes its parent, further down.
  std::size_t deep = 0;
  const std::string message = refusal([&](MeshTree& t) {
    const auto [n, lane] = find_lane(t, false, 20);
    deep = n;
    t.nodes[n].set_link(lane, static_cast<std::int32_t>(n) - 1, MeshNode::inner);
  });
  EXPECT_GT(deep, 1U);
  EXPECT_EQ(message, node(deep) + "has a child that is not after it");
  std::size_t count = 0;
  const std::string orphan = refusal([&](MeshTree& t) {
    count = t.nodes.size();
    t.nodes.push_back(t.nodes.back());
  });
  EXPECT_EQ(orphan, node(count) + "is no earlier node's child");
}

TEST(CheckTree, RefusesDamagedLanes) {
  EXPECT_EQ(refusal([](MeshTree& t) { std::fill_n(t.nodes[0].link, MeshNode::width, MeshNode::unused_link); }),
            node(0) + "is empty");
  EXPECT_EQ(refusal([](MeshTree& t) { t.nodes[0].link[0] = MeshNode::unused_link; }), node(0) + "is empty");
  EXPECT_EQ(refusal([](MeshTree& t) { t.nodes[0].link[1] = MeshNode::unused_link; }),
            node(0) + "has a gap between its lanes");
}

TEST(CheckTree, RefusesDamagedLeaves) {
  for (const auto& [child, count] : std::vector<std::pair<std::int32_t, int>>{
           {512, 1}, {511, 2}, {0, 5}, {0, 6}, {last_index, 1}, {last_index, 2}}) {
    std::size_t at = 0;
    const std::string message = refusal([&, child = child, count = count](MeshTree& t) {
      const auto [n, lane] = find_lane(t, true);
      at = n;
      t.nodes[n].set_link(lane, child, count);
    });
    EXPECT_EQ(message, node(at) + "has a leaf out of range") << child << " " << count;
  }
  EXPECT_EQ(refusal([](MeshTree& t) { t.leaves[7] = t.leaves[6]; }), "m: leaf triangle 7 is not one of the mesh");
  EXPECT_EQ(refusal([](MeshTree& t) { t.leaves[7].triangle = 512; }), "m: leaf triangle 7 is not one of the mesh");
  EXPECT_EQ(refusal([](MeshTree& t) { t.leaves[7].triangle = -1; }), "m: leaf triangle 7 is not one of the mesh");
  EXPECT_EQ(refusal([](MeshTree& t) { t.leaves[7].vertices[2] ^= 1; }), "m: leaf triangle 7 is not one of the mesh");
  EXPECT_EQ(refusal([](MeshTree& t) { t.leaves.pop_back(); }), "m: 511 leaf triangles for a mesh of 512");
  EXPECT_EQ(refusal([](MeshTree& t) { t.nodes.clear(); }), "m: a tree without nodes");
  EXPECT_EQ(refusal([](MeshTree& t) {
              auto [n, lane] = find_lane(t, true);
              for (int skip = 1; t.nodes[n].count(lane) == 1; ++skip) std::tie(n, lane) = find_lane(t, true, skip);
              t.nodes[n].set_link(lane, t.nodes[n].child(lane), 1);
            }),
            "m: the tree does not reach every triangle");
}

TEST(CheckTree, RefusesALeafHeldTwice) {
  // For coincident triangles every leaf has the same box: only the count is wrong.
  const MeshArrays arrays = make_mesh_arrays(coincident(40), "m");
  MeshTree tree = arrays.tree;
  const auto [n, lane] = find_lane(tree, true, 1);
  const auto [m, other] = find_lane(tree, true);
  tree.nodes[n].link[lane] = tree.nodes[m].link[other];
  EXPECT_EQ(error_of([&] {
              check_tree(tree, {arrays.vertices, arrays.triangles}, "m");
            }),
            node(n) + "shares a triangle with another leaf");
}

TEST(CheckTree, RefusesDamagedBoundsOnlyWhenAskedTo) {
  for (const bool leaf : {false, true}) {
    const auto spoil = [&](const std::function<void(MeshNode&, int lane)>& edit) {
      std::size_t at = 0;
      const auto damage = [&](MeshTree& t) {
        const auto [n, lane] = find_lane(t, leaf);
        at = n;
        edit(t.nodes[n], lane);
      };
      const std::string message = refusal(damage), expected = node(at) + "does not contain its triangle ";
      EXPECT_EQ(message.substr(0, expected.size()), expected);
      MeshArrays arrays = make_mesh_arrays(rounded_mesh(shapes::sphere(3)), "m");
      damage(arrays.tree);
      EXPECT_NO_THROW(check_tree(arrays.tree, {arrays.vertices, arrays.triangles}, "m"));
    };
    for (int axis = 0; axis < 3; ++axis) {
      spoil([&](MeshNode& n, int lane) { n.lower[axis][lane] = static_cast<std::int16_t>(n.lower[axis][lane] + 3); });
      spoil([&](MeshNode& n, int lane) { n.upper[axis][lane] = static_cast<std::int16_t>(n.upper[axis][lane] - 3); });
      spoil([&](MeshNode& n, int lane) { std::swap(n.lower[axis][lane], n.upper[axis][lane]); });
      spoil([&](MeshNode& n, int lane) {
        n.normal[axis][lane] = static_cast<std::int8_t>(n.normal[axis][lane] + (n.normal[axis][lane] > 0 ? -60 : 60));
      });
    }
    spoil([](MeshNode& n, int lane) { n.slab_lower[lane] = static_cast<std::int16_t>(n.slab_lower[lane] + 2); });
    spoil([](MeshNode& n, int lane) { n.slab_upper[lane] = static_cast<std::int16_t>(n.slab_upper[lane] - 2); });
  }
}

TEST(CheckTree, RefusesChainsThatAreTooDeep) {
  const MeshArrays arrays = make_mesh_arrays(coincident(1), "m");
  const auto chain = [&](int nodes) {
    MeshTree tree = arrays.tree;
    const MeshNode last = tree.nodes[0];
    MeshNode link = last;
    tree.nodes.assign(static_cast<std::size_t>(nodes), link);
    for (int n = 0; n < nodes; ++n) tree.nodes[n].set_link(0, n + 1, MeshNode::inner);
    tree.nodes.back() = last;
    check_tree(tree, {arrays.vertices, arrays.triangles}, "m");
  };
  EXPECT_NO_THROW(chain(MeshTree::max_depth + 1));
  EXPECT_EQ(error_of([&] { chain(MeshTree::max_depth + 2); }), "m: node 65 is too deep");
}

}  // namespace
}  // namespace encage
