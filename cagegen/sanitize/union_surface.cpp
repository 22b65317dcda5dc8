// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/union_surface.h"

#include "cagegen/geometry/cgal_mesh.h"
#include "cagegen/sanitize/edge_table.h"
#include "cagegen/sanitize/weld.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/boost/graph/Euler_operations.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace encage::io {

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;

using UnionKernel = CGAL::Exact_predicates_exact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<UnionKernel::Point_3>;

constexpr std::size_t most_parts = 100;
constexpr std::int64_t most_triangles = 100'000;
constexpr double negligible_edge = 1e-9;  // of the diagonal

/// The triangles of each part, parts in the order of their first triangles.
std::vector<std::vector<std::int64_t>> triangles_of_parts(const TriangleMesh& mesh) {
  const EdgeTable edges(mesh.triangles, mesh.vertices.rows());
  const std::vector<Side> twin = twins(edges, mesh.triangles.rows());
  std::vector<std::vector<std::int64_t>> parts;
  std::vector<bool> seen(static_cast<std::size_t>(mesh.triangles.rows()));
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (seen[first]) continue;
    seen[first] = true;
    std::vector<std::int64_t>& part = parts.emplace_back(1, static_cast<std::int64_t>(first));
    for (std::size_t i = 0; i < part.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const Side other = twin[static_cast<std::size_t>(3 * part[i] + k)];
        if (other < 0 || seen[triangle_of(other)]) continue;
        seen[triangle_of(other)] = true;
        part.push_back(triangle_of(other));
      }
    }
  }
  return parts;
}

TriangleMesh part_of(const TriangleMesh& mesh, const std::vector<std::int64_t>& rows) {
  TriangleMesh part;
  part.vertices = mesh.vertices;
  part.triangles.resize(static_cast<std::int64_t>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    part.triangles.row(static_cast<std::int64_t>(i)) = mesh.triangles.row(rows[i]);
  }
  drop_unused_vertices(part);
  return part;
}

bool boxes_meet(const std::vector<TriangleMesh>& parts) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const TriangleMesh& part : parts) {
    const Eigen::AlignedBox3d box = bounds(part);
    for (const Eigen::AlignedBox3d& other : boxes) {
      if (other.intersects(box)) return true;
    }
    boxes.push_back(box);
  }
  return false;
}

/// Intersections that are almost the same point would coincide once they are rounded.
void collapse_short_edges(SurfaceMesh& solid, double length) {
  const std::vector<SurfaceMesh::Edge_index> edges(solid.edges().begin(), solid.edges().end());
  for (const SurfaceMesh::Edge_index e : edges) {
    if (solid.is_removed(e)) continue;
    const auto& a = solid.point(solid.vertex(e, 0));
    const auto& b = solid.point(solid.vertex(e, 1));
    if (CGAL::to_double(CGAL::squared_distance(a, b)) > length * length) continue;
    if (CGAL::Euler::does_satisfy_link_condition(e, solid)) CGAL::Euler::collapse_edge(e, solid);
  }
}

}  // namespace

std::optional<TriangleMesh> union_surface(const TriangleMesh& mesh, const std::function<void()>& check) {
  if (mesh.triangles.rows() > most_triangles) return std::nullopt;
  const std::vector<std::vector<std::int64_t>> triangles = triangles_of_parts(mesh);
  if (triangles.size() < 2 || triangles.size() > most_parts) return std::nullopt;
  std::vector<TriangleMesh> parts;
  for (const std::vector<std::int64_t>& rows : triangles) {
    parts.push_back(part_of(mesh, rows));
    if (!is_closed_manifold(parts.back().triangles, parts.back().vertices.rows())) return std::nullopt;
    if (signed_volume(parts.back()) <= 0) return std::nullopt;
  }
  if (!boxes_meet(parts)) return std::nullopt;

  std::vector<SurfaceMesh> solids;
  for (const TriangleMesh& part : parts) {
    check();
    solids.push_back(makers::to_cgal<UnionKernel::Point_3>(part));
    if (pmp::does_self_intersect(solids.back())) return std::nullopt;
  }
  // Two by two, so that no part goes through many unions.
  for (; solids.size() > 1; solids.resize((solids.size() + 1) / 2)) {
    for (std::size_t i = 0; 2 * i < solids.size(); ++i) {
      check();
      if (2 * i + 1 == solids.size()) {
        solids[i] = std::move(solids[2 * i]);
        break;
      }
      SurfaceMesh both;
      if (!pmp::corefine_and_compute_union(solids[2 * i], solids[2 * i + 1], both)) return std::nullopt;
      solids[i] = std::move(both);
    }
  }
  SurfaceMesh& solid = solids.front();
  const bool same = static_cast<std::int64_t>(solid.number_of_vertices()) == mesh.vertices.rows() &&
                    static_cast<std::int64_t>(solid.number_of_faces()) == mesh.triangles.rows();
  if (same) return std::nullopt;
  collapse_short_edges(solid, negligible_edge * bounds(mesh).diagonal().norm());
  return makers::from_cgal(solid);
}

}  // namespace encage::io
