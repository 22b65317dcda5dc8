// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/surface_features.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

Vector vertex(const MeshView& mesh, std::uint32_t v) {
  return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[v].data()).cast<double>();
}

double angle(const Vector& a, const Vector& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

std::vector<std::int32_t> find_twins(const MeshView& mesh) {
  struct Entry {
    std::uint64_t edge;  // lower vertex, higher vertex
    std::int32_t side;
    bool operator<(const Entry& other) const { return edge != other.edge ? edge < other.edge : side < other.side; }
  };
  std::vector<Entry> entries;
  entries.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t u = mesh.triangles[t][k], v = mesh.triangles[t][(k + 1) % 3];
      entries.push_back({std::min(u, v) << 32 | std::max(u, v), static_cast<std::int32_t>(3 * t + k)});
    }
  }
  std::sort(entries.begin(), entries.end());
  std::vector<std::int32_t> twin(entries.size(), -1);
  for (std::size_t i = 0; i < entries.size();) {
    std::size_t end = i + 1;
    while (end < entries.size() && entries[end].edge == entries[i].edge) ++end;
    if (end - i == 2) {
      twin[static_cast<std::size_t>(entries[i].side)] = entries[i + 1].side;
      twin[static_cast<std::size_t>(entries[i + 1].side)] = entries[i].side;
    }
    i = end;
  }
  return twin;
}

}  // namespace

SurfaceFeatures make_surface_features(const MeshView& mesh, std::span<const MeshPart> parts,
                                      std::vector<std::int32_t> twin) {
  SurfaceFeatures features;
  features.twin = twin.empty() ? find_twins(mesh) : std::move(twin);
  features.face_normal.reserve(mesh.triangles.size());
  std::vector<Vector> sums(mesh.vertices.size(), Vector::Zero());
  std::vector<std::int32_t> sides(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Vector, 3> c;
    for (std::size_t k = 0; k < 3; ++k) c[k] = vertex(mesh, mesh.triangles[t][k]);
    const Vector n = (c[1] - c[0]).cross(c[2] - c[0]).stableNormalized();
    features.face_normal.emplace_back(n.cast<float>());
    for (std::size_t k = 0; k < 3; ++k) {
      sides[mesh.triangles[t][k]] = static_cast<std::int32_t>(3 * t + k);
      sums[mesh.triangles[t][k]] += angle(c[(k + 1) % 3] - c[k], c[(k + 2) % 3] - c[k]) * n;
    }
  }
  features.vertex_normal.reserve(sums.size());
  for (const Vector& sum : sums) features.vertex_normal.emplace_back(sum.stableNormalized().cast<float>());
  for (const MeshPart& part : parts) features.part_sides.push_back(sides[static_cast<std::size_t>(part.vertex)]);
  return features;
}

}  // namespace encage
