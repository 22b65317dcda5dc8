// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/cap.h"

#include "cagegen/sanitize/ear_clip.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/utility.h>

#include <algorithm>

namespace encage::io {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr std::size_t longest_optimal_loop = 200;

struct BoundaryEdge {
  std::int32_t component, from, to;
  Side side;
};

Kernel::Point_3 point(const Eigen::Vector3d& p) { return {p[0], p[1], p[2]}; }

/// Positions in the loop, or nothing.
std::vector<CGAL::Triple<int, int, int>> optimal_triangles(const TriangleMesh& mesh, const Loop& loop) {
  std::vector<Kernel::Point_3> points, beyond;  // beyond each edge: the apex of its triangle
  for (const Side s : loop) {
    points.push_back(point(mesh.vertex(head(mesh.triangles, s))));
    beyond.push_back(point(mesh.corner(triangle_of(s), (s % 3 + 2) % 3)));
  }
  std::vector<CGAL::Triple<int, int, int>> result;
  try {
    // Among Delaunay triangles alone, the search would be quicker, but ties would depend on addresses in memory.
    CGAL::Polygon_mesh_processing::triangulate_hole_polyline(points, beyond, std::back_inserter(result),
                                                             CGAL::parameters::use_delaunay_triangulation(false));
  } catch (const std::exception&) {
    result.clear();  // CGAL's preconditions do not allow every loop
  }
  if (result.size() != loop.size() - 2) result.clear();
  return result;
}

}  // namespace

std::vector<Loop> boundary_loops(const Triangles& triangles, const EdgeTable& edges, const Components& components) {
  std::vector<BoundaryEdge> boundary;
  std::int32_t last_vertex = 0;
  edges.for_each_edge([&](std::span<const Side> sides) {
    if (sides.size() != 1) return;
    const Side s = sides[0];
    boundary.push_back({components.label[triangle_of(s)], head(triangles, s), tail(triangles, s), s});
    last_vertex = std::max({last_vertex, head(triangles, s), tail(triangles, s)});
  });
  const auto before = [](const BoundaryEdge& a, const BoundaryEdge& b) {
    return a.from != b.from ? a.from < b.from : a.component < b.component;
  };
  std::stable_sort(boundary.begin(), boundary.end(), before);
  std::vector<char> used(boundary.size(), 0);
  // The next unused edge from a vertex. Components are not mixed unless one is closed only together with another; every
  // vertex has as many edges in as out, so that any choice ends where it began.
  const auto next = [&](std::int32_t from, std::int32_t component) {
    const auto is_free = [&](const BoundaryEdge& edge) { return !used[&edge - boundary.data()]; };
    const auto begin = std::lower_bound(boundary.begin(), boundary.end(), BoundaryEdge{component, from, 0, 0}, before);
    const auto end = std::upper_bound(begin, boundary.end(), BoundaryEdge{component, from, 0, 0}, before);
    if (const auto found = std::find_if(begin, end, is_free); found != end) return found;
    const auto first = std::lower_bound(boundary.begin(), boundary.end(), BoundaryEdge{-1, from, 0, 0}, before);
    const auto last = std::lower_bound(boundary.begin(), boundary.end(), BoundaryEdge{-1, from + 1, 0, 0}, before);
    const auto found = std::find_if(first, last, is_free);
    return found != last ? found : boundary.end();
  };

  std::vector<std::int32_t> path_index(static_cast<std::size_t>(last_vertex) + 1, -1);  // of a vertex on the path
  std::vector<Loop> loops;
  Loop path;  // begins in start.from, ends in `at`
  for (const BoundaryEdge& start : boundary) {
    std::int32_t at = start.from, component = start.component;
    path_index[at] = 0;
    for (;;) {
      const auto edge = next(at, component);
      if (edge == boundary.end()) break;
      component = edge->component;
      used[edge - boundary.begin()] = 1;
      path.push_back(edge->side);
      at = edge->to;
      if (path_index[at] < 0) {
        path_index[at] = static_cast<std::int32_t>(path.size());
        continue;
      }
      const auto first = path.begin() + path_index[at];
      loops.emplace_back(first, path.end());
      for (auto side = first + 1; side != path.end(); ++side) path_index[head(triangles, *side)] = -1;
      path.erase(first, path.end());
    }
    path_index[start.from] = -1;
  }
  return loops;
}

void cap_loop(const TriangleMesh& mesh, const Loop& loop, std::vector<std::array<std::int32_t, 3>>& triangles,
              std::int64_t& work) {
  std::vector<std::int32_t> vertices;
  for (const Side s : loop) vertices.push_back(head(mesh.triangles, s));
  const auto size = static_cast<std::int64_t>(loop.size());
  if (size > 3 && loop.size() <= longest_optimal_loop && size * size * size <= work) {
    work -= size * size * size;
    const std::vector<CGAL::Triple<int, int, int>> optimal = optimal_triangles(mesh, loop);
    for (const CGAL::Triple<int, int, int>& t : optimal) {
      std::array<int, 3> corners = {t.first, t.second, t.third};
      std::sort(corners.begin(), corners.end());  // in the order of the loop: with its orientation
      triangles.push_back({vertices[corners[0]], vertices[corners[1]], vertices[corners[2]]});
    }
    if (!optimal.empty()) return;
  }
  clip_ears(mesh.vertices, vertices, triangles);
}

}  // namespace encage::io
