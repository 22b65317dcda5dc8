// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace ENCAGE_EXPORT encage {

/// n x 3: one vertex in each row, in the user's unit.
using Vertices = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// m x 3: the indices of three vertices in each row, counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;

struct TriangleMesh {
  Vertices vertices;
  Triangles triangles;

  Eigen::Vector3d vertex(std::int32_t v) const { return vertices.row(v).transpose(); }
  Eigen::Vector3d corner(std::int64_t triangle, int k) const {
    return vertices.row(triangles(triangle, k)).transpose();
  }
};

/// Polygons with any number of corners. `corners` holds the vertex indices of all polygons one after the other, those
/// of polygon i from `first[i]` to `first[i + 1]`; so `first` has one entry more than there are polygons.
struct PolygonMesh {
  Vertices vertices;
  std::vector<std::int32_t> corners;
  std::vector<std::int64_t> first{0};

  std::int64_t polygon_count() const { return static_cast<std::int64_t>(first.size()) - 1; }
};

/// Whether a source mesh encloses space.
enum class Solid {
  closed,        ///< yes: every edge has a matching one, and the body is surface and interior
  capped,        ///< yes, once boundary loops were closed by added triangles
  surface_only,  ///< no interior is known, so questions of containment answer "maybe"
};

const char* name(Solid solid) noexcept;

/// The axis-aligned bounding box of the vertices that triangles use; empty() if there are none.
Eigen::AlignedBox3d bounds(const TriangleMesh& mesh);

/// Signed volume by the divergence theorem, in cubic units. It has a meaning for closed meshes. The sum follows the
/// order of the triangles, so it is the same on every machine.
double signed_volume(const TriangleMesh& mesh);

/// Labels each triangle with its connected component, from 0, in the order of the components' first triangles.
/// Triangles are connected where they share the index of a vertex. Returns the number of components.
int triangle_components(const TriangleMesh& mesh, std::vector<std::int32_t>& label);

/// True if every directed edge (a, b) occurs as often as (b, a), so that the surface has no boundary. Triangles with
/// two equal indices are ignored.
bool is_closed(const TriangleMesh& mesh);

/// The origin of the local frame of a mesh with these bounds. On each axis it is 0 if the centre is within four
/// diagonals of 0, and a rounded centre otherwise. So `vertex - origin` is exact in double for every vertex (Sterbenz),
/// and local coordinates keep at least 21 bits of float32 across the diagonal.
Eigen::Vector3d local_origin(const Eigen::AlignedBox3d& bounds);

}  // namespace encage
