// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/bvh.h"

#include <encage/broadphase.h>

#include <array>
#include <vector>

namespace encage {

/// Corners of a triangle, exact in float32.
using TriangleF = std::array<Eigen::Vector3f, 3>;

/// A surface in the local frame of its hierarchy, ready for queries.
struct Surface {
  std::vector<BvhNode> nodes;        ///< Bvh::nodes; leaves refer to `triangles`
  std::vector<TriangleF> triangles;  ///< in leaf order
  /// One vertex of each component: where the surface does not touch another
  /// one, it stands for the whole component.
  std::vector<Eigen::Vector3f> component_points;
  bool closed = false;  ///< has no boundary: winding numbers mean something
  double radius = 0;    ///< largest distance of a vertex from the local origin, rounded up

  bool empty() const { return triangles.empty(); }
};

class Shape {
 public:
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< body frame = origin + local frame
  Solid solid = Solid::closed;
  double fine_error = 0;       ///< distance of a source vertex from its fine vertex, at most
  std::vector<Surface> cages;  ///< fine to coarse; each closed
  Surface fine;                ///< may be empty
  /// Per component, the six fine vertices that are extreme along the local axes; empty without fine mesh.
  std::vector<std::array<Eigen::Vector3f, 6>> extremes;

  /// The surface whose box bounds the body, and the error of that.
  const Surface& outer() const { return fine.empty() ? cages.front() : fine; }
  double outer_error() const { return fine.empty() ? 0 : fine_error; }
};

}  // namespace encage
