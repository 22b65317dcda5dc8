// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/convex_hull.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/boost/graph/helpers.h>
#include <CGAL/convex_hull_3.h>
#include <CGAL/optimal_bounding_box.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace encage::makers {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Face = SurfaceMesh::Face_index;
using Halfedge = SurfaceMesh::Halfedge_index;
using Vertex = SurfaceMesh::Vertex_index;

/// The four corners of the triangles at an edge lie in one plane.
bool flat_edge(const SurfaceMesh& hull, Halfedge h) {
  const auto point = [&](Halfedge at) { return hull.point(hull.target(at)); };
  const Halfedge back = hull.opposite(h);
  return CGAL::coplanar(point(h), point(back), point(hull.next(h)), point(hull.next(back)));
}

/// A number per face, the same throughout a facet.
std::vector<std::size_t> label_facets(const SurfaceMesh& hull) {
  constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::vector<std::size_t> label(hull.number_of_faces(), none);
  std::vector<Face> stack;
  std::size_t count = 0;
  for (const Face start : hull.faces()) {
    if (label[start] != none) continue;
    label[start] = count;
    stack.push_back(start);
    while (!stack.empty()) {
      const Face f = stack.back();
      stack.pop_back();
      for (const Halfedge h : CGAL::halfedges_around_face(hull.halfedge(f), hull)) {
        const Face g = hull.face(hull.opposite(h));
        if (label[g] != none || !flat_edge(hull, h)) continue;
        label[g] = count;
        stack.push_back(g);
      }
    }
    ++count;
  }
  return label;
}

}  // namespace

std::optional<TriangleMesh> convex_hull(std::span<const Eigen::Vector3d> points) {
  std::vector<Kernel::Point_3> input;
  for (const Eigen::Vector3d& p : points) input.emplace_back(p.x(), p.y(), p.z());
  // Also spares CGAL sets of points that are all equal, which it refuses.
  std::sort(input.begin(), input.end());
  input.erase(std::unique(input.begin(), input.end()), input.end());
  if (input.size() < 4) return std::nullopt;
  SurfaceMesh hull;
  CGAL::convex_hull_3(input.begin(), input.end(), hull);
  if (hull.number_of_faces() < 4 || !CGAL::is_closed(hull) || !CGAL::is_triangle_mesh(hull)) return std::nullopt;

  const std::vector<std::size_t> label = label_facets(hull);
  // Extreme points are those where three facets meet.
  std::map<Kernel::Point_3, std::int32_t> number;
  const auto facets_at = [&](Vertex v) {
    std::set<std::size_t> facets;
    for (const Face f : CGAL::faces_around_target(hull.halfedge(v), hull)) facets.insert(label[f]);
    return facets.size();
  };
  for (const Vertex v : hull.vertices()) {
    if (facets_at(v) >= 3) number.emplace(hull.point(v), 0);
  }
  TriangleMesh result;
  result.vertices.resize(static_cast<std::int64_t>(number.size()), 3);
  std::int32_t count = 0;
  for (auto& [point, id] : number) {
    result.vertices.row(count) << point.x(), point.y(), point.z();
    id = count++;
  }
  // Once around every facet, from its first vertex.
  std::map<std::size_t, std::map<Vertex, Vertex>> outline;
  for (const Halfedge h : hull.halfedges()) {
    const std::size_t facet = label[hull.face(h)];
    if (label[hull.face(hull.opposite(h))] != facet) outline[facet][hull.source(h)] = hull.target(h);
  }
  std::vector<std::array<std::int32_t, 3>> triangles;
  for (const auto& [facet, next] : outline) {
    std::vector<std::int32_t> corner;
    Vertex v = next.begin()->first;
    for (std::size_t i = 0; i < next.size(); ++i, v = next.at(v)) {
      const auto known = number.find(hull.point(v));
      if (known != number.end()) corner.push_back(known->second);
    }
    std::rotate(corner.begin(), std::min_element(corner.begin(), corner.end()), corner.end());
    for (std::size_t i = 2; i < corner.size(); ++i) triangles.push_back({corner[0], corner[i - 1], corner[i]});
  }
  std::sort(triangles.begin(), triangles.end());
  result.triangles.resize(static_cast<std::int64_t>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) result.triangles(static_cast<std::int64_t>(t), k) = triangles[t][k];
  }
  return result;
}

Eigen::Matrix3d smallest_box_axes(std::span<const Eigen::Vector3d> points) {
  // Coordinates of order one: the search compares volumes.
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  const double size = box.diagonal().norm();
  std::vector<Kernel::Point_3> input;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d x = (p - box.center()) / size;
    input.emplace_back(x.x(), x.y(), x.z());
  }
  CGAL::Aff_transformation_3<Kernel> turned;
  CGAL::oriented_bounding_box(input, turned, CGAL::parameters::use_convex_hull(true).random_seed(1));
  Eigen::Matrix3d axes;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) axes(row, column) = turned.m(row, column);
  }
  return axes;
}

}  // namespace encage::makers
