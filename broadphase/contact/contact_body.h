// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/contact/contact_leaf.h"
#include "broadphase/contact/index_map.h"
#include "broadphase/contact/nearest_point.h"
#include "broadphase/shape/compound.h"

#include <vector>

namespace encage {

/// Largest cosine of the normals of two features that face each other.
inline constexpr double facing_cosine = -0.25;

/// An edge that can meet another one, in the common frame; see ContactEdges.
struct ContactEdge {
  Eigen::Vector3d start, along;
  std::array<Eigen::Vector3d, 2> out;
  double length;
  std::int32_t side;  ///< 3 t + k
};

/// One body of a pair while contacts are searched. It keeps its memory from query to query.
struct ContactBody {
  const Surface* surface = nullptr;
  MeshView mesh;  ///< with the surroundings of a tile
  const SurfaceFeatures* features = nullptr;
  std::uint64_t shape = 0;  ///< SimpleShape::number
  AffineMap map, inverse;   ///< from the local frame to the common one, scale included, and back
  AffineMap step;           ///< positions at the start to those at the end, seen from the other body
  double scale = 1;
  Eigen::Matrix3d rotation;  ///< map without the scale
  bool solid = true;         ///< otherwise the body is its surface alone, and contacts are two-sided
  bool round = false;        ///< of degenerate triangles only: the core of a sphere or a capsule
  std::int32_t first_vertex = 0, first_triangle = 0, part = 0;

  IndexMap leaf_index, vertex_index;
  std::vector<ContactLeaf> leaves;
  std::vector<ContactVertex> vertices;
  std::vector<ContactEdges> edges;

  void place(const MovingPart& moving, const AffineMap& to_common, std::int32_t number);
  /// Returns how far a point of the body, in the common frame, moves during the step, seen from the other body.
  Eigen::Vector3d displacement(const Eigen::Vector3d& p) const { return step(p) - p; }

  /// Returns the index in `leaves` of a leaf of the tree.
  std::int32_t leaf(std::int32_t first, std::int32_t count);
  /// Describes side k of a triangle; false if no other edge can meet it.
  bool edge(std::int32_t triangle, int k, const TriangleD& corners, const Eigen::Vector3d& normal,
            ContactEdge& edge) const;
  /// Returns the index in `vertices` of a corner of a triangle.
  std::int32_t vertex(std::int32_t triangle, int corner);

  std::int32_t vertex_number(std::int32_t triangle, int corner) const {
    return static_cast<std::int32_t>(
        mesh.triangles[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(corner)]);
  }
  /// Returns a vertex in the local frame.
  Eigen::Vector3d local_vertex(std::int32_t vertex) const {
    return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[static_cast<std::size_t>(vertex)].data()).cast<double>();
  }
  Eigen::Vector3d located(std::int32_t vertex) const {
    return map.linear.lazyProduct(local_vertex(vertex)) + map.offset;
  }
  /// A tile is a part of a larger surface, and shares the features along its border with other parts.
  bool is_tile() const { return !surface->foreign.empty(); }
  bool is_own(std::int32_t triangle) const {
    return static_cast<std::size_t>(triangle) < surface->mesh.triangles.size();
  }
  Eigen::Vector3d position(std::int32_t triangle, int corner) const { return located(vertex_number(triangle, corner)); }
  TriangleD triangle(std::int32_t t) const { return {position(t, 0), position(t, 1), position(t, 2)}; }
  /// Turns a direction of the local frame.
  Eigen::Vector3d direction(const Eigen::Vector3d& local) const { return rotation.lazyProduct(local); }
  Eigen::Vector3d local_direction(const Eigen::Vector3d& common) const {
    return rotation.transpose().lazyProduct(common);
  }
  /// Unit normal of a triangle, rounded to float; 0 if it is degenerate.
  Eigen::Vector3d face_normal(std::int32_t t) const {
    return direction(features->face_normal[static_cast<std::size_t>(t)].cast<double>());
  }
  Eigen::Vector3d normal(const SurfacePoint& point) const {
    return direction(feature_normal(*surface, *features, point));
  }

 private:
  std::int32_t add_vertex(std::int32_t triangle, int corner);
  void add_edges(std::int32_t triangle, const TriangleD& corners, const Eigen::Vector3d& normal, unsigned owned,
                 ContactLeaf& leaf);
};

}  // namespace encage
