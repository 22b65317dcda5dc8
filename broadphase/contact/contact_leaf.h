// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/tree/mesh_tree.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <limits>
#include <span>

namespace encage {

/// The triangles of a leaf side by side in the common frame of a pair, with what nearest points need.
struct ContactLeaf {
  static constexpr int width = MeshTree::leaf_size;
  using Lanes = std::array<double, width>;
  using Vectors = std::array<Lanes, 3>;  ///< [coordinate]

  alignas(32) std::array<Vectors, 3> corner;
  alignas(32) std::array<Vectors, 3> edge;    ///< from corner k to the next one
  alignas(32) std::array<Vectors, 3> inward;  ///< in the triangle's plane, across edge k, of any length
  alignas(32) std::array<Lanes, 3> weight;    ///< 1 / squared length of edge k; 0 if it has none
  alignas(32) Vectors normal;                 ///< unit length; 0 for a degenerate triangle
  alignas(32) Lanes bias;  ///< added to cosines with the normal: degenerate triangles face everything
  Eigen::Vector3d lower = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());  ///< box of the corners
  Eigen::Vector3d upper = -lower;
  std::int32_t count = 0;
  std::array<std::int32_t, width> triangle{};
  std::int32_t first_vertex = 0, vertex_count = 0;  ///< among the vertices of the query that triangles of it own
  std::int32_t first_edges = 0, edge_blocks = 0;

  /// Sets a lane, given the unit normal, or 0 for a degenerate triangle. Unused lanes must repeat a triangle.
  void set(int lane, std::int32_t number, const std::array<Eigen::Vector3d, 3>& corners, const Eigen::Vector3d& n);
};

/// Edges that can meet edges of the other body, side by side, in the common frame.
struct ContactEdges {
  static constexpr int width = 4;
  using Vectors = std::array<std::array<double, width>, 3>;  ///< [coordinate]

  alignas(32) Vectors along{};
  /// In the plane of each of its triangles, out of the triangle, unit length; 0 if there is no triangle. Directions of
  /// non-negative products with both, at right angles to the edge, lead to points whose nearest feature is the edge.
  alignas(32) std::array<Vectors, 2> out{};
  alignas(32) Vectors start{};
  std::array<double, width> length{};      ///< 0 in unused lanes
  std::array<std::int32_t, width> side{};  ///< 3 t + k
};

/// A vertex of one body, and the nearest triangles of the other one found so far.
struct ContactVertex {
  Eigen::Vector3d position;                                 ///< in the common frame
  Eigen::Vector3d normal;                                   ///< unit length, outward; 0 if none is defined
  double most_cosine;                                       ///< of normals that face this one
  double any = std::numeric_limits<double>::infinity();     ///< squared distance of the nearest triangle
  double facing = std::numeric_limits<double>::infinity();  ///< of the nearest one that faces the vertex
  std::int32_t any_triangle = -1, facing_triangle = -1;
  std::int32_t vertex = -1;
  std::int32_t side = -1;  ///< 3 t + k: a triangle t that has it as corner k
};

/// Lets every vertex know of the triangles of a leaf within reach. The result is the same on every instruction set.
void note_nearest(const ContactLeaf& leaf, std::span<ContactVertex> vertices, double reach);

/// Returns the bits of the edges of `b` that may have a common perpendicular with edge `lane` of `a` that lies in b's
/// region, up to `slack` radians.
std::uint32_t edges_may_meet(const ContactEdges& a, int lane, const ContactEdges& b, double slack);

/// Returns the bits of the triangles of `b` that may touch triangle `lane` of `a`: all but those that an axis of
/// coordinates or the plane of one of the two triangles separates. `slack` covers rounding.
std::uint32_t may_touch(const ContactLeaf& a, int lane, const ContactLeaf& b, double slack);

}  // namespace encage
