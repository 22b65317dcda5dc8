// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Meshes to and from CGAL. Slow to compile: for the few files that use CGAL anyway.

#include <encage/mesh.h>

#include <CGAL/Surface_mesh.h>

#include <cstdint>
#include <vector>

namespace encage::makers {

/// Vertex i and face i are those of the mesh. `mesh` must be an oriented manifold.
template <class CgalPoint>
CGAL::Surface_mesh<CgalPoint> to_cgal(const TriangleMesh& mesh) {
  using SurfaceMesh = CGAL::Surface_mesh<CgalPoint>;
  SurfaceMesh result;
  const auto vertices = static_cast<unsigned>(mesh.vertices.rows());
  const auto faces = static_cast<unsigned>(mesh.triangles.rows());
  result.reserve(vertices, 3 * faces / 2, faces);
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    result.add_vertex(CgalPoint(mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2)));
  }
  const auto vertex = [&](std::int64_t t, int k) {
    return typename SurfaceMesh::Vertex_index(static_cast<unsigned>(mesh.triangles(t, k)));
  };
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    result.add_face(vertex(t, 0), vertex(t, 1), vertex(t, 2));
  }
  return result;
}

/// Of triangles; removed elements are left out.
template <class CgalPoint>
TriangleMesh from_cgal(const CGAL::Surface_mesh<CgalPoint>& mesh) {
  TriangleMesh result;
  result.vertices.resize(static_cast<std::int64_t>(mesh.number_of_vertices()), 3);
  result.triangles.resize(static_cast<std::int64_t>(mesh.number_of_faces()), 3);
  std::vector<std::int32_t> number(mesh.num_vertices());
  std::int32_t count = 0;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    result.vertices.row(count) << CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z());
    number[v] = count++;
  }
  std::int64_t row = 0;
  for (const auto f : mesh.faces()) {
    int k = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh)) result.triangles(row, k++) = number[v];
    ++row;
  }
  return result;
}

}  // namespace encage::makers
