// SPDX-License-Identifier: Apache-2.0
#include "src/asset/view.h"

#include <encage/asset.h>

namespace encage {

TriangleMesh copy_mesh(const MeshView& view) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(view.vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(view.triangles.size()), 3);
  for (std::size_t v = 0; v < view.vertices.size(); ++v) {
    for (std::size_t k = 0; k < 3; ++k) mesh.vertices(v, k) = view.vertices[v][k];
  }
  for (std::size_t t = 0; t < view.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) mesh.triangles(t, k) = static_cast<std::int32_t>(view.triangles[t][k]);
  }
  return mesh;
}

CageHierarchy copy_hierarchy(const AssetView& view) {
  CageHierarchy hierarchy = view.description();
  if (const auto fine = view.fine()) hierarchy.fine = copy_mesh(*fine);
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) hierarchy.levels[i].mesh = copy_mesh(view.cage(i));
  return hierarchy;
}

CageHierarchy read_asset(const std::filesystem::path& file, Verify verify) {
  return copy_hierarchy(AssetView(file, verify));
}

}  // namespace encage
