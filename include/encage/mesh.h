// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace ENCAGE_EXPORT encage {

/// n x 3, one vertex a row, in the user's unit.
using Vertices = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// m x 3 indices into the vertices, counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;

struct TriangleMesh {
  Vertices vertices;
  Triangles triangles;

  Eigen::Vector3d vertex(std::int32_t v) const { return vertices.row(v).transpose(); }
  Eigen::Vector3d corner(std::int64_t triangle, int k) const {
    return vertices.row(triangles(triangle, k)).transpose();
  }
};

/// Polygons of any size: `corners` holds the vertex indices of all polygons one
/// after the other, polygon i from `first[i]` to `first[i + 1]` (first has one
/// entry more than there are polygons).
struct PolygonMesh {
  Vertices vertices;
  std::vector<std::int32_t> corners;
  std::vector<std::int64_t> first{0};

  std::int64_t polygon_count() const { return static_cast<std::int64_t>(first.size()) - 1; }
};

/// What a source mesh says about the space it encloses (design.md, section 1).
enum class Solid {
  closed,        ///< every edge is matched: surface and interior
  capped,        ///< boundary loops were closed by added triangles
  surface_only,  ///< no interior is known; containment answers "maybe"
};

const char* name(Solid solid) noexcept;

/// Axis-aligned bounds of the vertices that triangles use; empty() if none.
Eigen::AlignedBox3d bounds(const TriangleMesh& mesh);

/// Signed volume by the divergence theorem, in cubic units; summed in index
/// order, hence the same on every machine. Meaningful for closed meshes.
double signed_volume(const TriangleMesh& mesh);

/// Label (0-based, in order of the smallest triangle index) of the connected
/// component of each triangle; triangles are connected through shared vertex
/// indices. Returns the number of components.
int triangle_components(const TriangleMesh& mesh, std::vector<std::int32_t>& label);

/// True if every directed edge (a,b) occurs as often as (b,a): the surface has
/// no boundary. Triangles with two equal indices are ignored.
bool is_closed(const TriangleMesh& mesh);

/// Origin of the local frame of a mesh with these bounds. Per axis it is 0 if
/// the centre is within four diagonals of 0, and a rounded centre otherwise, so
/// that `vertex - origin` is exact in double for every vertex (Sterbenz) and
/// local coordinates keep at least 21 bits of float32 across the diagonal.
Eigen::Vector3d local_origin(const Eigen::AlignedBox3d& bounds);

}  // namespace encage
