// SPDX-License-Identifier: GPL-3.0-or-later
// The starts that CGAL makes, in one file: its headers are slow to compile.
#include "cagegen/collapse/cage_editor.h"
#include "cagegen/collapse/starts.h"
#include "cagegen/geometry/cgal_mesh.h"
#include "src/mesh/rounding.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace encage::makers {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

}  // namespace

TriangleMesh alpha_wrap(const TriangleMesh& clean, double alpha, double offset) {
  std::vector<Kernel::Point_3> points;
  std::vector<std::array<std::size_t, 3>> faces;
  for (const auto& v : clean.vertices.rowwise()) points.emplace_back(v[0], v[1], v[2]);
  for (const auto& t : clean.triangles.rowwise()) {
    faces.push_back({static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]), static_cast<std::size_t>(t[2])});
  }
  SurfaceMesh wrap;
  CGAL::alpha_wrap_3(points, faces, alpha, offset, wrap);
  return outermost_components(from_cgal(wrap));
}

std::optional<TriangleMesh> wrap_start(const Obstacle& obstacle, const TriangleMesh& clean, double alpha, double offset,
                                       double clearance) {
  TriangleMesh cage = alpha_wrap(clean, alpha, offset);
  round_vertices(cage);
  if (cage.triangles.rows() == 0) return std::nullopt;
  if (clear(obstacle, cage, clearance)) return cage;
  // A wrap encloses its input, but single triangles may come closer than the offset.
  return offset_start(obstacle, cage, 2 * clearance, true, clearance);
}

const std::optional<TriangleMesh>& WrapStarts::get(double parameter) {
  Entry* entry = nullptr;
  {
    const std::lock_guard lock(mutex_);
    entry = &entries_[parameter];
  }
  const double alpha = diagonal_ / parameter;
  std::call_once(entry->once,
                 [&] { entry->start = wrap_start(obstacle_, clean_, alpha, alpha * wrap_offset, clearance_); });
  return entry->start;
}

TriangleMesh make_manifold(const TriangleMesh& mesh) {
  // Opposite triangles on the same corners enclose nothing.
  std::vector<std::array<std::int32_t, 4>> keys;  // sorted corners, triangle
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    std::array<std::int32_t, 3> corner{mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)};
    std::sort(corner.begin(), corner.end());
    keys.push_back({corner[0], corner[1], corner[2], static_cast<std::int32_t>(t)});
  }
  std::sort(keys.begin(), keys.end());
  std::vector<bool> dropped(keys.size());
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    if (!std::equal(keys[i].begin(), keys[i].begin() + 3, keys[i + 1].begin())) continue;
    dropped[keys[i][3]] = dropped[keys[i + 1][3]] = true;
    ++i;
  }
  std::vector<std::array<double, 3>> points;
  std::vector<std::vector<std::size_t>> polygons;
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    points.push_back({mesh.vertices(v, 0), mesh.vertices(v, 1), mesh.vertices(v, 2)});
  }
  for (std::size_t t = 0; t < dropped.size(); ++t) {
    if (dropped[t]) continue;
    const auto row = mesh.triangles.row(static_cast<std::int64_t>(t));
    polygons.push_back(
        {static_cast<std::size_t>(row(0)), static_cast<std::size_t>(row(1)), static_cast<std::size_t>(row(2))});
  }
  CGAL::Polygon_mesh_processing::orient_polygon_soup(points, polygons);
  TriangleMesh result;
  result.triangles.resize(static_cast<std::int64_t>(polygons.size()), 3);
  std::vector<std::int32_t> number(points.size(), -1);
  std::vector<std::size_t> used;
  for (std::size_t t = 0; t < polygons.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      std::int32_t& n = number[polygons[t][k]];
      if (n < 0) {
        n = static_cast<std::int32_t>(used.size());
        used.push_back(polygons[t][k]);
      }
      result.triangles(static_cast<std::int64_t>(t), k) = n;
    }
  }
  result.vertices.resize(static_cast<std::int64_t>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v) {
    const auto& p = points[used[v]];
    result.vertices.row(static_cast<std::int64_t>(v)) << p[0], p[1], p[2];
  }
  return result;
}

}  // namespace encage::makers
