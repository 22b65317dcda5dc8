// SPDX-License-Identifier: Apache-2.0
#include "src/tree/mesh_tree.h"

#include "src/tree/bvh.h"
#include "src/tree/slab.h"

#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace encage {
namespace {

constexpr int width = MeshNode::width;

double half_area(const BvhNode& node) {
  const double x = static_cast<double>(node.upper[0]) - static_cast<double>(node.lower[0]);
  const double y = static_cast<double>(node.upper[1]) - static_cast<double>(node.lower[1]);
  const double z = static_cast<double>(node.upper[2]) - static_cast<double>(node.lower[2]);
  return x * y + y * z + z * x;
}

/// Collapses the nodes of a binary tree to wide ones.
class Widener {
 public:
  Widener(const Bvh& binary, const TriangleMesh& mesh, const TreeGrid& grid)
      : binary_(binary), slabs_(mesh, grid, binary.order) {
    tree_.grid = grid;
    tree_.leaves.reserve(binary.order.size());
    for (const std::int32_t t : binary.order) {
      tree_.leaves.push_back({{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)}, t});
    }
  }

  MeshTree widen() {
    if (binary_.nodes.empty()) return {};
    struct Task {
      std::int32_t wide, binary;
    };
    std::vector<Task> tasks{{0, 0}};
    tree_.nodes.push_back(MeshNode{});
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      std::array<std::int32_t, width> lanes;
      const int count = open(task.binary, lanes);
      for (int lane = 0; lane < width; ++lane) {
        const BvhNode& node = binary_.nodes[lanes[lane < count ? lane : 0]];
        MeshNode& wide = tree_.nodes[task.wide];
        for (int axis = 0; axis < 3; ++axis) {
          // Unused lanes have empty boxes, so that tests rarely report them.
          wide.lower[axis][lane] = lane < count ? tree_.grid.below(axis, node.lower[axis]) : std::int16_t{32767};
          wide.upper[axis][lane] = lane < count ? tree_.grid.above(axis, node.upper[axis]) : std::int16_t{-32768};
        }
        wide.set_link(lane, 0, MeshNode::unused);
        if (lane >= count) continue;
        const Slab slab = slabs_.fit(first_triangle(lanes[lane]), end_of_triangles(lanes[lane]));
        for (int axis = 0; axis < 3; ++axis) wide.normal[axis][lane] = slab.normal[axis];
        wide.slab_lower[lane] = slab.lower;
        wide.slab_upper[lane] = slab.upper;
        const auto child = node.leaf() ? node.first : static_cast<std::int32_t>(tree_.nodes.size());
        wide.set_link(lane, child, node.count);
        if (node.leaf()) continue;
        tasks.push_back({child, lanes[lane]});
        tree_.nodes.push_back(MeshNode{});
      }
    }
    return std::move(tree_);
  }

 private:
  /// Collects the descendants that become lanes, always opening the largest box.
  int open(std::int32_t root, std::array<std::int32_t, width>& lanes) const {
    int count = 0;
    lanes[count++] = root;
    while (count < width) {
      int largest = -1;
      double area = -1;
      for (int i = 0; i < count; ++i) {
        const BvhNode& node = binary_.nodes[lanes[i]];
        if (node.leaf() || !(half_area(node) > area)) continue;
        area = half_area(node);
        largest = i;
      }
      if (largest < 0) break;
      const std::int32_t first = binary_.nodes[lanes[largest]].first;
      lanes[largest] = first;
      lanes[count++] = first + 1;
    }
    return count;
  }

  // Triangles below a node are contiguous in Bvh::order.
  std::int32_t first_triangle(std::int32_t n) const {
    while (!binary_.nodes[n].leaf()) n = binary_.nodes[n].first;
    return binary_.nodes[n].first;
  }
  std::int32_t end_of_triangles(std::int32_t n) const {
    while (!binary_.nodes[n].leaf()) n = binary_.nodes[n].first + 1;
    return binary_.nodes[n].first + binary_.nodes[n].count;
  }

  const Bvh& binary_;
  SlabFitter slabs_;
  MeshTree tree_;
};

class TreeChecker {
 public:
  TreeChecker(const MeshTreeView& tree, const MeshView& mesh, const std::string& place)
      : tree_(tree), mesh_(mesh), place_(place) {}

  void check_links() {
    if (tree_.nodes.empty()) throw Error(place_ + ": a tree without nodes");
    if (tree_.leaves.size() != mesh_.triangles.size()) {
      throw Error(place_ + ": " + std::to_string(tree_.leaves.size()) + " leaf triangles for a mesh of " +
                  std::to_string(mesh_.triangles.size()));
    }
    check_leaf_triangles();
    depth_.assign(tree_.nodes.size(), -1);
    depth_[0] = 0;
    std::vector<bool> covered(tree_.leaves.size(), false);
    std::size_t covered_count = 0;
    for (std::size_t n = 0; n < tree_.nodes.size(); ++n) {
      if (depth_[n] < 0) fail(n, "is no earlier node's child");
      for (int lane = 0; lane < width; ++lane) {
        const int count = tree_.nodes[n].count(lane);
        if (count == MeshNode::unused) {
          if (lane == 0) fail(n, "is empty");
          continue;
        }
        if (lane > 0 && tree_.nodes[n].count(lane - 1) == MeshNode::unused) fail(n, "has a gap between its lanes");
        if (count == MeshNode::inner) {
          check_inner(n, lane);
          continue;
        }
        check_leaf(n, lane);
        for (std::int32_t i = tree_.nodes[n].child(lane); i < tree_.nodes[n].child(lane) + count; ++i) {
          if (covered[i]) fail(n, "shares a triangle with another leaf");
          covered[i] = true;
          ++covered_count;
        }
      }
    }
    if (covered_count != covered.size()) throw Error(place_ + ": the tree does not reach every triangle");
  }

  /// Checks that every triangle lies in all boxes and slabs on the path to it. Call it after check_links().
  void check_bounds() const {
    struct Lane {
      std::size_t node;
      int lane;
    };
    std::vector<Lane> above(tree_.nodes.size());
    for (std::size_t n = 0; n < tree_.nodes.size(); ++n) {
      for (int lane = 0; lane < width && tree_.nodes[n].count(lane) != MeshNode::unused; ++lane) {
        const std::int32_t first = tree_.nodes[n].child(lane), count = tree_.nodes[n].count(lane);
        if (count == MeshNode::inner) above[first] = {n, lane};
        for (std::int32_t i = first; i < first + count; ++i) {
          for (const std::int32_t v : tree_.leaves[i].vertices) {
            for (Lane at{n, lane};; at = above[at.node]) {
              if (!contains(tree_.nodes[at.node], at.lane, mesh_.vertices[v])) {
                fail(at.node, "does not contain its triangle " + std::to_string(tree_.leaves[i].triangle));
              }
              if (at.node == 0) break;
            }
          }
        }
      }
    }
  }

 private:
  [[noreturn]] void fail(std::size_t node, const std::string& reason) const {
    throw Error(place_ + ": node " + std::to_string(node) + " " + reason);
  }

  void check_leaf_triangles() const {
    std::vector<bool> seen(mesh_.triangles.size(), false);
    for (std::size_t i = 0; i < tree_.leaves.size(); ++i) {
      const LeafTriangle& leaf = tree_.leaves[i];
      const auto t = static_cast<std::size_t>(leaf.triangle);
      const bool valid = leaf.triangle >= 0 && t < seen.size() && !seen[t] &&
                         std::equal(leaf.vertices.begin(), leaf.vertices.end(), mesh_.triangles[t].begin(),
                                    [](std::int32_t x, std::uint32_t y) { return static_cast<std::uint32_t>(x) == y; });
      if (!valid) throw Error(place_ + ": leaf triangle " + std::to_string(i) + " is not one of the mesh");
      seen[t] = true;
    }
  }

  void check_inner(std::size_t n, int lane) {
    const auto child = static_cast<std::size_t>(tree_.nodes[n].child(lane));
    if (tree_.nodes[n].child(lane) < 0 || child <= n || child >= tree_.nodes.size()) {
      fail(n, "has a child that is not after it");
    }
    if (depth_[child] >= 0) fail(child, "has two parents");
    depth_[child] = depth_[n] + 1;
    if (depth_[child] > MeshTree::max_depth) fail(child, "is too deep");
  }

  void check_leaf(std::size_t n, int lane) const {
    const std::int32_t first = tree_.nodes[n].child(lane), count = tree_.nodes[n].count(lane);
    if (count < 0 || count > MeshTree::leaf_size || first < 0 ||
        first > static_cast<std::int64_t>(tree_.leaves.size()) - count) {
      fail(n, "has a leaf out of range");
    }
  }

  bool contains(const MeshNode& node, int lane, const std::array<float, 3>& vertex) const {
    Eigen::Vector3d position;
    for (int axis = 0; axis < 3; ++axis) {
      if (vertex[axis] < tree_.lower(node, axis, lane) || vertex[axis] > tree_.upper(node, axis, lane)) return false;
      position[axis] = tree_.grid.coordinate(axis, static_cast<double>(vertex[axis]));
    }
    const double height = Slab::height({node.normal[0][lane], node.normal[1][lane], node.normal[2][lane]}, position);
    return MeshNode::slab_unit * node.slab_lower[lane] <= height &&
           height <= MeshNode::slab_unit * node.slab_upper[lane];
  }

  const MeshTreeView& tree_;
  const MeshView& mesh_;
  const std::string& place_;
  std::vector<int> depth_;
};

}  // namespace

std::int16_t TreeGrid::below(int axis, float x) const {
  const double exact = coordinate(axis, static_cast<double>(x));
  auto rounded = static_cast<std::int16_t>(std::clamp(std::floor(exact), -32768.0, 32767.0));
  while (at(axis, rounded) > x && rounded > -32768) --rounded;
  return rounded;
}

std::int16_t TreeGrid::above(int axis, float x) const {
  const double exact = coordinate(axis, static_cast<double>(x));
  auto rounded = static_cast<std::int16_t>(std::clamp(std::ceil(exact), -32768.0, 32767.0));
  while (at(axis, rounded) < x && rounded < 32767) ++rounded;
  return rounded;
}

TreeGrid make_grid(std::span<const std::array<float, 3>> vertices) {
  std::array<double, 3> low = {}, high = {};
  double largest = 0;
  for (std::size_t axis = 0; axis < 3 && !vertices.empty(); ++axis) {
    const auto [least, most] = std::minmax_element(vertices.begin(), vertices.end(),
                                                   [&](const auto& x, const auto& y) { return x[axis] < y[axis]; });
    low[axis] = static_cast<double>((*least)[axis]);
    high[axis] = static_cast<double>((*most)[axis]);
    largest = std::max({largest, std::abs(low[axis]), std::abs(high[axis])});
  }
  TreeGrid grid;
  // The step is a little more than the extent requires, and never so small that different grid coordinates round to the
  // same number.
  double step = std::max(largest * 0x1p-21, static_cast<double>(std::numeric_limits<float>::min()));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double half = 0.5 * (high[axis] - low[axis]);
    step = std::max(step, half / 32766 * (1 + 0x1p-20));
    grid.middle[axis] = static_cast<float>(0.5 * (low[axis] + high[axis]));
  }
  grid.step = static_cast<float>(step);
  return grid;
}

MeshTree build_mesh_tree(const TriangleMesh& mesh) {
  if (mesh.triangles.rows() >= std::int64_t{1} << 29) throw Error("the mesh has 2^29 triangles or more");
  std::vector<std::array<float, 3>> vertices(static_cast<std::size_t>(mesh.vertices.rows()));
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    for (std::size_t k = 0; k < 3; ++k) vertices[v][k] = static_cast<float>(mesh.vertices(v, k));
  }
  const TreeGrid grid = make_grid(vertices);
  const Bvh binary = build_bvh(mesh);
  return Widener(binary, mesh, grid).widen();
}

void check_tree(const MeshTreeView& tree, const MeshView& mesh, const std::string& place) {
  TreeChecker(tree, mesh, place).check_links();
}

void check_bounds(const MeshTreeView& tree, const MeshView& mesh, const std::string& place) {
  TreeChecker checker(tree, mesh, place);
  checker.check_links();
  checker.check_bounds();
}

}  // namespace encage
