// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape.h"

#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace encage {
namespace {

constexpr double unit = std::numeric_limits<double>::epsilon();

void check(const TriangleMesh& mesh, const std::string& what) {
  if (mesh.vertices.rows() > std::numeric_limits<std::int32_t>::max() ||
      mesh.triangles.rows() > std::numeric_limits<std::int32_t>::max()) {
    throw Error(what + ": more than 2^31 elements");
  }
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const double x = mesh.vertices(v, axis);
      const bool in_range = std::abs(x) <= static_cast<double>(std::numeric_limits<float>::max());
      if (!in_range || static_cast<double>(static_cast<float>(x)) != x) {
        throw Error(what + ": vertex " + std::to_string(v) + " is not exact in float32");
      }
    }
  }
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = mesh.triangles(t, k);
      if (v < 0 || v >= mesh.vertices.rows()) {
        throw Error(what + ": triangle " + std::to_string(t) + " refers to vertex " + std::to_string(v));
      }
    }
  }
}

Surface make_surface(const TriangleMesh& mesh) {
  Surface surface;
  Bvh tree = build_bvh(mesh);
  surface.nodes = std::move(tree.nodes);
  surface.triangles.reserve(tree.order.size());
  double squared_radius = 0;
  for (const std::int32_t t : tree.order) {
    TriangleF triangle;
    for (int k = 0; k < 3; ++k) {
      squared_radius = std::max(squared_radius, mesh.corner(t, k).squaredNorm());
      triangle[k] = mesh.corner(t, k).cast<float>();
    }
    surface.triangles.push_back(triangle);
  }
  surface.radius = std::sqrt(squared_radius) * (1 + 8 * unit);

  std::vector<std::int32_t> label;
  triangle_components(mesh, label);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    // Labels count up in the order of the first triangles.
    if (label[t] == static_cast<std::int32_t>(surface.component_points.size())) {
      surface.component_points.emplace_back(mesh.corner(t, 0).cast<float>());
    }
  }
  surface.closed = is_closed(mesh);
  return surface;
}

std::vector<std::array<Eigen::Vector3f, 6>> extreme_vertices(const TriangleMesh& mesh) {
  std::vector<std::int32_t> label;
  const int components = triangle_components(mesh, label);
  std::vector<std::array<Eigen::Vector3f, 6>> extremes(static_cast<std::size_t>(components));
  std::vector<bool> seen(extremes.size(), false);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    auto& mine = extremes[label[t]];
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3f v = mesh.corner(t, k).cast<float>();
      if (!seen[label[t]]) mine.fill(v);
      seen[label[t]] = true;
      for (int axis = 0; axis < 3; ++axis) {
        if (v[axis] < mine[2 * axis][axis]) mine[2 * axis] = v;
        if (v[axis] > mine[2 * axis + 1][axis]) mine[2 * axis + 1] = v;
      }
    }
  }
  return extremes;
}

}  // namespace

ShapePtr make_shape(const CageHierarchy& hierarchy) {
  if (hierarchy.levels.empty() && hierarchy.fine.triangles.rows() == 0) {
    throw Error("hierarchy has neither cages nor a fine mesh");
  }
  if (hierarchy.levels.size() > std::numeric_limits<std::int16_t>::max()) throw Error("hierarchy has too many levels");
  if (!hierarchy.origin.allFinite()) throw Error("hierarchy: the origin is not finite");
  if (!(hierarchy.fine_error >= 0) || std::isinf(hierarchy.fine_error)) {
    throw Error("hierarchy: fine_error is not a finite distance");
  }
  auto shape = std::make_shared<Shape>();
  shape->origin = hierarchy.origin;
  shape->solid = hierarchy.solid;
  shape->fine_error = hierarchy.fine_error;
  check(hierarchy.fine, "fine mesh");
  shape->fine = make_surface(hierarchy.fine);
  shape->extremes = extreme_vertices(hierarchy.fine);
  for (std::size_t k = 0; k < hierarchy.levels.size(); ++k) {
    const TriangleMesh& cage = hierarchy.levels[k].mesh;
    const std::string what = "cage " + std::to_string(k);
    if (cage.triangles.rows() == 0) throw Error(what + ": no triangles");
    check(cage, what);
    shape->cages.push_back(make_surface(cage));
    if (!shape->cages.back().closed) throw Error(what + ": not closed");
  }
  return shape;
}

int level_count(const Shape& shape) noexcept { return static_cast<int>(shape.cages.size()); }

std::int64_t level_triangles(const Shape& shape, int level) noexcept {
  return static_cast<std::int64_t>(shape.cages[level].triangles.size());
}

}  // namespace encage
