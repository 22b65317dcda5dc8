// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/mesh/mesh_view.h"

#include <encage/mesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace encage {

/// The grid to which boxes of a tree are rounded outward: 2^16 grid coordinates over the largest extent of the mesh,
/// with the same step along all axes.
struct TreeGrid {
  std::array<float, 3> middle = {};
  float step = 0;  ///< > 0; at() increases strictly

  float at(int axis, std::int16_t coordinate) const { return middle[axis] + static_cast<float>(coordinate) * step; }
  /// Converts a coordinate to a grid coordinate, without rounding to an integer.
  double coordinate(int axis, double x) const {
    return (x - static_cast<double>(middle[axis])) / static_cast<double>(step);
  }
  std::int16_t below(int axis, float x) const;  ///< the last grid coordinate not above x, which the grid covers
  std::int16_t above(int axis, float x) const;  ///< the first one not below x
  /// Grid steps. Bounds how far at() is from its coordinate: two roundings in float.
  double rounding() const {
    const float far = std::max({std::abs(middle[0]), std::abs(middle[1]), std::abs(middle[2])});
    return 0x1p-22 * (0x1p15 + static_cast<double>(far) / static_cast<double>(step));
  }
};

/// Returns a grid that covers the vertices. The same vertices give the same grid on every machine.
TreeGrid make_grid(std::span<const std::array<float, 3>> vertices);

/// Eight boxes side by side, as stored in an asset: three cache lines. Everything below a box also lies in a slab,
/// between two parallel planes. Where a surface is nearly flat but not parallel to the axes, the box is as thick as it
/// is wide; the slab is thin.
struct alignas(64) MeshNode {
  static constexpr int width = 8;
  static constexpr int inner = 0, unused = -1;
  static constexpr int normal_size = 127;  ///< length of a slab's normal, before rounding
  static constexpr int slab_unit = 256;    ///< of slab_lower and slab_upper

  std::int16_t lower[3][width];  ///< grid coordinates, rounded outward
  std::int16_t upper[3][width];
  std::uint32_t link[width];     ///< low 29 bits: index; above: 0 inner, 1 to 6 triangles of a leaf, 7 unused
  std::int8_t normal[3][width];  ///< slab_lower <= normal . x / slab_unit <= slab_upper, x in grid coordinates
  std::int16_t slab_lower[width];
  std::int16_t slab_upper[width];
  std::uint8_t padding[8];  ///< always 0

  /// For an inner lane, the index of its node, which is greater than this node's. For a leaf, its first entry of
  /// MeshTree::leaves.
  std::int32_t child(int lane) const { return child_of(link[lane]); }
  /// The number of triangles of a leaf; otherwise `inner` or `unused`.
  int count(int lane) const { return count_of(link[lane]); }
  void set_link(int lane, std::int32_t child, int count) {
    link[lane] =
        count == unused ? unused_link : static_cast<std::uint32_t>(count) << 29 | static_cast<std::uint32_t>(child);
  }

  static constexpr std::uint32_t unused_link = 7U << 29;
  static std::int32_t child_of(std::uint32_t link) { return static_cast<std::int32_t>(link & ~unused_link); }
  static int count_of(std::uint32_t link) { return link >= unused_link ? unused : static_cast<int>(link >> 29); }
};
static_assert(sizeof(MeshNode) == 192);

/// A triangle as stored in a leaf: its vertex indices, and its number in the mesh.
struct LeafTriangle {
  std::array<std::int32_t, 3> vertices;
  std::int32_t triangle;
};
static_assert(sizeof(LeafTriangle) == 16);

/// Bounding volume tree of a mesh in its own frame, 8 wide. Node 0 is the root; used lanes come first. The same mesh
/// gives the same tree on every machine.
struct MeshTree {
  static constexpr int leaf_size = 4;   ///< largest number of triangles in a leaf
  static constexpr int max_depth = 64;  ///< of any node; the root has depth 0. Bounds the stack of a traversal

  std::vector<MeshNode> nodes;
  std::vector<LeafTriangle> leaves;  ///< leaf after leaf, every triangle once
  TreeGrid grid;
};

/// Builds the tree; it is empty for a mesh without triangles. Vertices must be finite and exact in float32, indices in
/// range. Throws Error if there are more triangles than the links can address, 2^29.
MeshTree build_mesh_tree(const TriangleMesh& mesh);

/// A view of a tree.
struct MeshTreeView {
  std::span<const MeshNode> nodes;
  std::span<const LeafTriangle> leaves;
  TreeGrid grid;

  MeshTreeView() = default;
  MeshTreeView(std::span<const MeshNode> n, std::span<const LeafTriangle> l, const TreeGrid& g)
      : nodes(n), leaves(l), grid(g) {}
  MeshTreeView(const MeshTree& tree) : nodes(tree.nodes), leaves(tree.leaves), grid(tree.grid) {}  // NOLINT: a view

  float lower(const MeshNode& node, int axis, int lane) const { return grid.at(axis, node.lower[axis][lane]); }
  float upper(const MeshNode& node, int axis, int lane) const { return grid.at(axis, node.upper[axis][lane]); }
};

/// Proves that a traversal of the tree is safe and complete: every node but the root is the child of exactly one
/// earlier one, every triangle of the mesh is in exactly one leaf, and depth and leaf sizes keep their limits. Linear
/// time. Throws Error, its message starting with `place`.
void check_tree(const MeshTreeView& tree, const MeshView& mesh, const std::string& place);

/// Calls check_tree(), and proves that boxes and slabs contain everything below them. O(n log n), too slow for every
/// load.
void check_bounds(const MeshTreeView& tree, const MeshView& mesh, const std::string& place);

}  // namespace encage
