// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/separation/triangle_pair.h"
#include "broadphase/shape/surface_features.h"

namespace encage {

/// A point of a surface, and the feature that it lies on.
struct SurfacePoint {
  enum class Kind : std::uint8_t { vertex, edge, face };
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double distance = 0;         ///< to the point asked for, >= 0
  double lower = 0;            ///< no triangle is nearer; less than `distance` only beside thin triangles
  std::int32_t triangle = -1;  ///< one that has the feature
  Kind kind = Kind::face;
  std::int32_t corner = 0;  ///< of the triangle: the vertex, or the edge from it to the next one
};

/// Triangles with a normal (a product of two edges) no longer than its root times the longest edge squared are thin:
/// their normal does not tell heights. Their nearest points are those of their edges, too far by their width at most.
inline constexpr double thin_square = 1e-16;

/// A triangle, and a bound from below of the squared distance to all, but for rounding.
struct NearestTriangle {
  std::int32_t triangle;
  double squared;
};

/// The nearest point of a triangle (Ericson 2005, section 5.1.5), and the feature that it lies on.
SurfacePoint nearest_in_triangle(const Eigen::Vector3d& p, const TriangleD& t);

/// Directions that the normals of triangles must have: those n with n . axis < most.
struct NormalFilter {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  double most = 1;  ///< by default every triangle passes
};

/// Finds the point of a surface, of triangles that pass the filter, that is nearest to p and nearer than `reach`; false
/// if there is none. All in the surface's local frame. Of several equally near triangles the first in the mesh is
/// named. Never allocates.
bool nearest_point(const MeshArraysView& surface, const Eigen::Vector3d& p, double reach, SurfacePoint& nearest,
                   const NormalFilter& filter = {});

/// Unit normal of the feature, outward if the surface is closed: of a face, the sum of both faces of an edge, or a
/// vertex's, rounded to float. 0 for degenerate features.
Eigen::Vector3d feature_normal(const MeshArraysView& surface, const SurfaceFeatures& features,
                               const SurfacePoint& point);

}  // namespace encage
