// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/tree/mesh_arrays.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace encage {

/// What contacts need of a mesh besides its tree: which triangles share an edge, and normals that tell inside from
/// outside.
struct SurfaceFeatures {
  std::vector<std::int32_t> twin;  ///< of side 3 t + k, corners k and k + 1: the side opposite; -1 unless there is one
  std::vector<Eigen::Vector3f> face_normal;  ///< per triangle, unit length; 0 if it is degenerate
  /// Per vertex, unit length: the normals of its triangles weighted by their angles there. The surface's nearest point
  /// is a vertex only for points whose side this normal tells (Baerentzen and Aanaes 2005). 0 where triangles cancel.
  std::vector<Eigen::Vector3f> vertex_normal;

  std::vector<std::int32_t> part_sides;  ///< per part of the mesh, a side that begins at its vertex

  std::int64_t bytes() const noexcept {
    const auto of = [](const auto& all) { return static_cast<std::int64_t>(all.size() * sizeof(all[0])); };
    return of(twin) + of(face_normal) + of(vertex_normal) + of(part_sides);
  }
  std::int32_t twin_of(std::int32_t side) const { return twin[static_cast<std::size_t>(side)]; }
};

/// Linear time but for the sorting of edges, which is left out if `twin` comes from a mesh of the same triangles.
SurfaceFeatures make_surface_features(const MeshView& mesh, std::span<const MeshPart> parts,
                                      std::vector<std::int32_t> twin = {});

/// Calls visit(triangle) for the triangles around corner k of a triangle, as far as they hang together by edges of two.
template <class Visit>
void visit_around(const SurfaceFeatures& features, std::int32_t triangle, int k, const Visit& visit) {
  // The side that ends at the vertex leads on; its twin begins there.
  std::int32_t side = 3 * triangle + k;
  do {
    visit(side / 3);
    side = features.twin_of(side - side % 3 + (side + 2) % 3);
  } while (side >= 0 && side / 3 != triangle);
  if (side >= 0) return;
  // A boundary: the rest lies the other way round. The twin of the side that begins at the vertex ends there.
  side = features.twin_of(3 * triangle + k);
  while (side >= 0 && side / 3 != triangle) {
    visit(side / 3);
    side = features.twin_of(side - side % 3 + (side + 1) % 3);
  }
}

}  // namespace encage
