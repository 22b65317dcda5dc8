// SPDX-License-Identifier: Apache-2.0
#include "src/wide_tree.h"

#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/bvh.h"

namespace encage {
namespace {

constexpr int width = WideNode::width;

double half_area(const BvhNode& node) {
  const double x = static_cast<double>(node.upper[0]) - static_cast<double>(node.lower[0]);
  const double y = static_cast<double>(node.upper[1]) - static_cast<double>(node.lower[1]);
  const double z = static_cast<double>(node.upper[2]) - static_cast<double>(node.lower[2]);
  return x * y + y * z + z * x;
}

/// Joins the nodes of a binary tree to wide ones.
class Widener {
 public:
  Widener(const Bvh& binary, const TriangleMesh& mesh) : binary_(binary) {
    tree_.leaves.reserve(binary.order.size());
    for (const std::int32_t t : binary.order) {
      tree_.leaves.push_back({{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)}, t});
    }
  }

  WideTree widen() {
    if (binary_.nodes.empty()) return {};
    struct Task {
      std::int32_t wide, binary;
    };
    std::vector<Task> tasks{{0, 0}};
    tree_.nodes.emplace_back();
    while (!tasks.empty()) {
      const Task task = tasks.back();
      tasks.pop_back();
      std::array<std::int32_t, width> lanes;
      const int count = open(task.binary, lanes);
      for (int lane = 0; lane < width; ++lane) {
        const BvhNode& node = binary_.nodes[lanes[lane < count ? lane : 0]];
        WideNode& wide = tree_.nodes[task.wide];
        for (int axis = 0; axis < 3; ++axis) {
          wide.lower[axis][lane] = node.lower[axis];
          wide.upper[axis][lane] = node.upper[axis];
        }
        wide.child[lane] = 0;
        wide.count[lane] = WideNode::unused;
        if (lane >= count) continue;
        wide.count[lane] = node.count;
        wide.child[lane] = node.leaf() ? node.first : static_cast<std::int32_t>(tree_.nodes.size());
        if (node.leaf()) continue;
        tasks.push_back({wide.child[lane], lanes[lane]});
        tree_.nodes.emplace_back();
      }
    }
    return std::move(tree_);
  }

 private:
  /// The descendants that become lanes: always the largest box is opened.
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

  const Bvh& binary_;
  WideTree tree_;
};

class Checker {
 public:
  Checker(const WideTreeView& tree, const MeshView& mesh, const std::string& place)
      : tree_(tree), mesh_(mesh), place_(place) {}

  void check() {
    if (tree_.nodes.empty()) throw Error(place_ + ": a tree without nodes");
    if (tree_.leaves.size() != mesh_.triangles.size()) {
      throw Error(place_ + ": " + std::to_string(tree_.leaves.size()) + " leaf triangles for a mesh of " +
                  std::to_string(mesh_.triangles.size()));
    }
    check_leaf_triangles();
    check_finite(0);
    depth_.assign(tree_.nodes.size(), -1);
    depth_[0] = 0;
    std::vector<bool> covered(tree_.leaves.size(), false);
    std::size_t covered_count = 0;
    for (std::size_t n = 0; n < tree_.nodes.size(); ++n) {
      if (depth_[n] < 0) fail(n, "is no earlier node's child");
      for (int lane = 0; lane < width; ++lane) {
        const std::int32_t count = tree_.nodes[n].count[lane];
        if (count == WideNode::unused) {
          if (lane == 0) fail(n, "is empty");
          continue;
        }
        if (lane > 0 && tree_.nodes[n].count[lane - 1] == WideNode::unused) fail(n, "has a gap between its lanes");
        if (count == WideNode::inner) {
          check_inner(n, lane);
          continue;
        }
        check_leaf(n, lane);
        for (std::int32_t i = tree_.nodes[n].child[lane]; i < tree_.nodes[n].child[lane] + count; ++i) {
          if (covered[i]) fail(n, "shares a triangle with another leaf");
          covered[i] = true;
          ++covered_count;
        }
      }
    }
    if (covered_count != covered.size()) throw Error(place_ + ": the tree does not reach every triangle");
  }

 private:
  [[noreturn]] void fail(std::size_t node, const char* reason) const {
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

  void check_finite(std::size_t n) const {
    const WideNode& node = tree_.nodes[n];
    for (int lane = 0; lane < width; ++lane) {
      for (int axis = 0; axis < 3 && node.count[lane] != WideNode::unused; ++axis) {
        if (!std::isfinite(node.lower[axis][lane]) || !std::isfinite(node.upper[axis][lane])) {
          fail(n, "has a box that is not finite");
        }
      }
    }
  }

  void check_inner(std::size_t n, int lane) {
    const auto child = static_cast<std::size_t>(tree_.nodes[n].child[lane]);
    if (tree_.nodes[n].child[lane] < 0 || child <= n || child >= tree_.nodes.size()) {
      fail(n, "has a child that is not after it");
    }
    if (depth_[child] >= 0) fail(child, "has two parents");
    depth_[child] = depth_[n] + 1;
    if (depth_[child] > WideTree::max_depth) fail(child, "is too deep");
    check_finite(child);
    const WideNode& below = tree_.nodes[child];
    for (int i = 0; i < width; ++i) {
      if (below.count[i] == WideNode::unused) continue;
      for (int axis = 0; axis < 3; ++axis) {
        if (!contains(n, lane, axis, below.lower[axis][i]) || !contains(n, lane, axis, below.upper[axis][i])) {
          fail(n, "does not contain its child");
        }
      }
    }
  }

  void check_leaf(std::size_t n, int lane) const {
    const std::int32_t first = tree_.nodes[n].child[lane], count = tree_.nodes[n].count[lane];
    if (count < 0 || count > WideTree::leaf_size || first < 0 ||
        first > static_cast<std::int64_t>(tree_.leaves.size()) - count) {
      fail(n, "has a leaf out of range");
    }
    for (std::int32_t i = first; i < first + count; ++i) {
      for (const std::int32_t v : tree_.leaves[i].vertices) {
        for (int axis = 0; axis < 3; ++axis) {
          if (!contains(n, lane, axis, mesh_.vertices[v][axis])) fail(n, "does not contain its triangle");
        }
      }
    }
  }

  bool contains(std::size_t n, int lane, int axis, float x) const {
    return tree_.nodes[n].lower[axis][lane] <= x && x <= tree_.nodes[n].upper[axis][lane];
  }

  const WideTreeView& tree_;
  const MeshView& mesh_;
  const std::string& place_;
  std::vector<int> depth_;
};

}  // namespace

WideTree build_wide_tree(const TriangleMesh& mesh) {
  const Bvh binary = build_bvh(mesh);
  return Widener(binary, mesh).widen();
}

void check_tree(const WideTreeView& tree, const MeshView& mesh, const std::string& place) {
  Checker(tree, mesh, place).check();
}

}  // namespace encage
