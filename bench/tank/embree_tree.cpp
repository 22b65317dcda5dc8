// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/embree_tree.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <utility>

namespace encage::tank {

// Embree knows our nodes as pointers: the reference plus 2^31, which is never null.
struct EmbreeTree::Callbacks {
  static void* to_pointer(Ref ref) {
    return reinterpret_cast<void*>(
        static_cast<std::uintptr_t>(static_cast<std::int64_t>(ref) + (std::int64_t{1} << 32)));
  }
  static Ref to_ref(const void* pointer) {
    return static_cast<Ref>(static_cast<std::int64_t>(reinterpret_cast<std::uintptr_t>(pointer)) -
                            (std::int64_t{1} << 32));
  }
  static EmbreeTree& tree(void* user) { return *static_cast<EmbreeTree*>(user); }

  static void* create_node(RTCThreadLocalAllocator, unsigned, void* user) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    std::vector<Node>& nodes = tree(user).nodes_;
    Node& node = nodes.emplace_back();
    for (int k = 0; k < 3; ++k) {
      std::fill_n(node.lower[k], width, infinity);
      std::fill_n(node.upper[k], width, -infinity);
    }
    return to_pointer(static_cast<Ref>(nodes.size() - 1));
  }
  static void set_children(void* pointer, void** children, unsigned count, void* user) {
    Node& node = tree(user).nodes_[to_ref(pointer)];
    for (unsigned c = 0; c < count; ++c) node.child[c] = to_ref(children[c]);
  }
  static void set_bounds(void* pointer, const RTCBounds** bounds, unsigned count, void* user) {
    Node& node = tree(user).nodes_[to_ref(pointer)];
    for (unsigned c = 0; c < count; ++c) {
      const RTCBounds& b = *bounds[c];
      const float lower[3] = {b.lower_x, b.lower_y, b.lower_z}, upper[3] = {b.upper_x, b.upper_y, b.upper_z};
      for (int k = 0; k < 3; ++k) node.lower[k][c] = lower[k], node.upper[k][c] = upper[k];
    }
  }
  static void* create_leaf(RTCThreadLocalAllocator, const RTCBuildPrimitive* primitives, std::size_t count,
                           void* user) {
    EmbreeTree& t = tree(user);
    Leaf leaf{box_of(primitives[0]), static_cast<std::int32_t>(t.primitives_.size()), static_cast<std::int32_t>(count)};
    for (std::size_t i = 1; i < count; ++i) extend(leaf.box, box_of(primitives[i]));
    t.primitives_.insert(t.primitives_.end(), primitives, primitives + count);
    t.leaves_.push_back(leaf);
    return to_pointer(~static_cast<Ref>(t.leaves_.size() - 1));
  }

  static Box box_of(const RTCBuildPrimitive& p) {
    return {{p.lower_x, p.lower_y, p.lower_z}, {p.upper_x, p.upper_y, p.upper_z}};
  }
  static void extend(Box& box, const Box& other) {
    for (int k = 0; k < 3; ++k) {
      box.lower[k] = std::min(box.lower[k], other.lower[k]);
      box.upper[k] = std::max(box.upper[k], other.upper[k]);
    }
  }
};

EmbreeTree::EmbreeTree(RTCBuildQuality quality) : quality_(quality), device_(rtcNewDevice(nullptr)) {
  if (!device_) throw std::bad_alloc();
  bvh_.reset(rtcNewBVH(device_.get()));
  if (!bvh_) throw std::bad_alloc();
}

void EmbreeTree::build(const Sweep& sweep) {
  vertices_.resize(static_cast<std::size_t>(sweep.mesh->vertices.rows()));
  for (std::size_t v = 0; v < vertices_.size(); ++v) {
    const Eigen::Vector3d p = sweep.start_of(static_cast<std::int32_t>(v));
    const Eigen::Vector3d q = sweep.end_of(static_cast<std::int32_t>(v));
    for (int k = 0; k < 3; ++k) {
      vertices_[v].lower[k] = -float_above(sweep.slack - std::min(p[k], q[k]));
      vertices_[v].upper[k] = float_above(sweep.slack + std::max(p[k], q[k]));
    }
  }
  const Triangles& triangles = sweep.mesh->triangles;
  input_.resize(static_cast<std::size_t>(triangles.rows()));
  for (std::size_t t = 0; t < input_.size(); ++t) {
    const std::int32_t* corner = triangles.data() + 3 * t;
    Box box = vertices_[corner[0]];
    Callbacks::extend(box, vertices_[corner[1]]);
    Callbacks::extend(box, vertices_[corner[2]]);
    input_[t] = {box.lower[0], box.lower[1], box.lower[2], 0,
                 box.upper[0], box.upper[1], box.upper[2], static_cast<unsigned>(t)};
  }
  nodes_.clear();
  leaves_.clear();
  primitives_.clear();
  if (input_.empty()) return;

  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.buildQuality = quality_;
  arguments.maxBranchingFactor = width;
  arguments.maxLeafSize = leaf_size;
  arguments.bvh = bvh_.get();
  arguments.primitives = input_.data();
  arguments.primitiveCount = arguments.primitiveArrayCapacity = input_.size();
  arguments.createNode = Callbacks::create_node;
  arguments.setNodeChildren = Callbacks::set_children;
  arguments.setNodeBounds = Callbacks::set_bounds;
  arguments.createLeaf = Callbacks::create_leaf;
  arguments.userPtr = this;
  void* root = nullptr;
  tbb::task_arena(1).execute([&] { root = rtcBuildBVH(&arguments); });
  if (root == nullptr || rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE) throw std::bad_alloc();
  root_ = Callbacks::to_ref(root);
}

struct EmbreeTree::TreeTraversal {
  const EmbreeTree& a;
  const EmbreeTree& b;
  std::vector<TrianglePair>& pairs;
  std::vector<std::pair<Ref, Ref>> stack{};

  static bool overlap(const Box& s, const Box& t) {
    bool apart = false;
    for (int k = 0; k < 3; ++k) apart |= s.upper[k] < t.lower[k] || t.upper[k] < s.lower[k];
    return !apart;
  }
  static std::array<bool, width> overlap(const Box& box, const Node& node) {
    std::array<bool, width> result;
    for (int c = 0; c < width; ++c) {
      int apart = 0;
      for (int k = 0; k < 3; ++k) {
        apart |= static_cast<int>(box.upper[k] < node.lower[k][c]) | static_cast<int>(node.upper[k][c] < box.lower[k]);
      }
      result[c] = apart == 0;
    }
    return result;
  }
  static Box child_box(const Node& node, int c) {
    Box box;
    for (int k = 0; k < 3; ++k) box.lower[k] = node.lower[k][c], box.upper[k] = node.upper[k][c];
    return box;
  }

  void nodes(const Node& node_a, const Node& node_b) {
    for (int i = 0; i < width; ++i) {
      const std::array<bool, width> hit = overlap(child_box(node_a, i), node_b);
      for (int j = 0; j < width; ++j) {
        if (hit[j]) stack.emplace_back(node_a.child[i], node_b.child[j]);
      }
    }
  }
  void leaves(const Leaf& leaf_a, const Leaf& leaf_b) {
    for (std::int32_t i = leaf_a.first; i < leaf_a.first + leaf_a.count; ++i) {
      const Box box = Callbacks::box_of(a.primitives_[i]);
      if (!overlap(box, leaf_b.box)) continue;
      for (std::int32_t j = leaf_b.first; j < leaf_b.first + leaf_b.count; ++j) {
        if (!overlap(box, Callbacks::box_of(b.primitives_[j]))) continue;
        pairs.push_back(
            {static_cast<std::int32_t>(a.primitives_[i].primID), static_cast<std::int32_t>(b.primitives_[j].primID)});
      }
    }
  }

  void run() {
    stack.assign(1, {a.root_, b.root_});
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      if (i >= 0 && j >= 0) {
        nodes(a.nodes_[i], b.nodes_[j]);
      } else if (i >= 0) {
        const std::array<bool, width> hit = overlap(b.leaves_[~j].box, a.nodes_[i]);
        for (int c = 0; c < width; ++c) {
          if (hit[c]) stack.emplace_back(a.nodes_[i].child[c], j);
        }
      } else if (j >= 0) {
        const std::array<bool, width> hit = overlap(a.leaves_[~i].box, b.nodes_[j]);
        for (int c = 0; c < width; ++c) {
          if (hit[c]) stack.emplace_back(i, b.nodes_[j].child[c]);
        }
      } else {
        leaves(a.leaves_[~i], b.leaves_[~j]);
      }
    }
  }
};

void EmbreeTree::overlaps(const EmbreeTree& a, const EmbreeTree& b, std::vector<TrianglePair>& pairs) {
  if (a.input_.empty() || b.input_.empty()) return;
  TreeTraversal{a, b, pairs}.run();
}

}  // namespace encage::tank
