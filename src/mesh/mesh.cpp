// SPDX-License-Identifier: Apache-2.0
#include <encage/cage.h>
#include <encage/mesh.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace encage {

const char* name(Solid solid) noexcept {
  switch (solid) {
    case Solid::closed: return "closed";
    case Solid::capped: return "capped";
    case Solid::surface_only: return "surface_only";
  }
  return "";
}

const char* name(Method method) noexcept {
  switch (method) {
    case Method::collapse: return "collapse";
    case Method::flow: return "flow";
    case Method::hull: return "hull";
  }
  return "";
}

Eigen::AlignedBox3d bounds(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) box.extend(mesh.corner(t, k));
  }
  return box;
}

double signed_volume(const TriangleMesh& mesh) {
  if (mesh.triangles.rows() == 0) return 0;
  // Coordinates are relative to a vertex of the mesh: far from 0 the terms would cancel.
  const Eigen::Vector3d reference = mesh.corner(0, 0);
  double six_volumes = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0) - reference;
    const Eigen::Vector3d b = mesh.corner(t, 1) - reference;
    const Eigen::Vector3d c = mesh.corner(t, 2) - reference;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

int triangle_components(const TriangleMesh& mesh, std::vector<std::int32_t>& label) {
  // The smallest index becomes the root of a union, so that roots are the first vertices.
  std::vector<std::int32_t> parent(static_cast<std::size_t>(mesh.vertices.rows()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 1; k < 3; ++k) {
      const std::int32_t a = root(mesh.triangles(t, 0));
      const std::int32_t b = root(mesh.triangles(t, k));
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<std::int32_t> number(parent.size(), -1);
  label.resize(static_cast<std::size_t>(mesh.triangles.rows()));
  int count = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    std::int32_t& n = number[root(mesh.triangles(t, 0))];
    if (n < 0) n = count++;
    label[t] = n;
  }
  return count;
}

bool is_closed(const TriangleMesh& mesh) {
  // Lists every undirected edge, with +1 for a < b and -1 for a > b. The sums must be 0.
  std::vector<std::pair<std::uint64_t, int>> edges;
  edges.reserve(static_cast<std::size_t>(mesh.triangles.rows()) * 3);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const auto row = mesh.triangles.row(t);
    if (row(0) == row(1) || row(1) == row(2) || row(2) == row(0)) continue;
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t a = static_cast<std::uint32_t>(row(k));
      const std::uint64_t b = static_cast<std::uint32_t>(row((k + 1) % 3));
      edges.emplace_back(a < b ? a << 32 | b : b << 32 | a, a < b ? 1 : -1);
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    int sum = 0;
    const std::uint64_t key = edges[i].first;
    for (; i < edges.size() && edges[i].first == key; ++i) sum += edges[i].second;
    if (sum != 0) return false;
  }
  return true;
}

Eigen::Vector3d local_origin(const Eigen::AlignedBox3d& bounds) {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  const Eigen::Vector3d centre = bounds.center();
  const double diagonal = bounds.diagonal().norm();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(centre[axis]) <= 4 * diagonal) continue;
    origin[axis] = centre[axis];
    if (!(diagonal > 0)) continue;  // a single point, or beyond double
    // The origin may lie anywhere within half a diagonal: a coarse power of two keeps it short in print.
    const double step = std::ldexp(1.0, std::ilogb(diagonal) - 2);
    const double rounded = std::nearbyint(centre[axis] / step) * step;
    if (std::isfinite(rounded)) origin[axis] = rounded;
  }
  return origin;
}

}  // namespace encage
