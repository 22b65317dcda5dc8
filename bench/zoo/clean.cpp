// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/clean.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>

#include <array>
#include <vector>

namespace encage::zoo {

bool is_clean(const TriangleMesh& mesh) {
  namespace PMP = CGAL::Polygon_mesh_processing;
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  std::vector<Kernel::Point_3> points;
  for (const auto& v : mesh.vertices.rowwise()) points.emplace_back(v.x(), v.y(), v.z());
  std::vector<std::array<std::size_t, 3>> triangles;
  for (const auto& t : mesh.triangles.rowwise()) {
    if (t(0) == t(1) || t(1) == t(2) || t(2) == t(0)) return false;
    triangles.push_back(
        {static_cast<std::size_t>(t(0)), static_cast<std::size_t>(t(1)), static_cast<std::size_t>(t(2))});
  }
  if (triangles.empty() || !is_closed(mesh)) return false;
  // A soup that had to be cut at an edge or a vertex is no manifold.
  const std::size_t before = points.size();
  if (!PMP::orient_polygon_soup(points, triangles) || points.size() != before) return false;
  CGAL::Surface_mesh<Kernel::Point_3> surface;
  PMP::polygon_soup_to_polygon_mesh(points, triangles, surface);
  return CGAL::is_closed(surface) && !PMP::does_self_intersect(surface);
}

}  // namespace encage::zoo
