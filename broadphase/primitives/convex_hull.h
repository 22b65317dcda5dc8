// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/mesh.h>

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace encage {

/// A closed mesh, or a flat one, of some of the points that it was made of.
struct HullMesh {
  std::vector<std::int32_t> points;  ///< indices: one for each vertex
  Triangles triangles;               ///< oriented outward
  bool flat = false;                 ///< encloses no volume: a point, a segment or a polygon
};

/// Computes the convex hull of n >= 1 finite points. Those within `flatness` of their extent of a plane, a line or a
/// point count as flat. Points that rounding does not prove outside may be left out. O(n log n) for most points.
HullMesh convex_hull(const std::vector<Eigen::Vector3d>& points, double flatness);

}  // namespace encage
