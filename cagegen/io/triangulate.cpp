// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/ear_clip.h"

#include <encage/bake.h>

#include <array>
#include <filesystem>
#include <span>

namespace encage {

TriangleMesh triangulate(const PolygonMesh& polygons) {
  std::vector<std::array<std::int32_t, 3>> triangles;
  triangles.reserve(polygons.corners.size());
  for (std::int64_t p = 0; p < polygons.polygon_count(); ++p) {
    const std::int64_t begin = polygons.first[p], end = polygons.first[p + 1];
    if (end - begin < 3) throw Error("face " + std::to_string(p) + ": has fewer than 3 corners");
    io::clip_ears(polygons.vertices, std::span(&polygons.corners[begin], static_cast<std::size_t>(end - begin)),
                  triangles);
  }
  TriangleMesh mesh;
  mesh.vertices = polygons.vertices;
  mesh.triangles = Eigen::Map<const Triangles>(triangles.empty() ? nullptr : triangles[0].data(),
                                               static_cast<Eigen::Index>(triangles.size()), 3);
  return mesh;
}

TriangleMesh read_mesh(const std::filesystem::path& file, ReadNotes* notes) {
  return triangulate(read_polygon_mesh(file, notes));
}

}  // namespace encage
