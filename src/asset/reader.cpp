// SPDX-License-Identifier: Apache-2.0
#include "src/asset/aligned_bytes.h"
#include "src/asset/glb.h"
#include "src/asset/view.h"

#include <encage/asset.h>

#include <span>
#include <string>
#include <string_view>

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

CageHierarchy decode_asset(std::string_view bytes, const std::string& name, Verify verify) {
  const AlignedBytes aligned(bytes);
  return copy_hierarchy(AssetView(aligned.span(), name, verify));
}

bool begins_like_asset(std::string_view bytes) {
  if (!bytes.starts_with("glTF") || bytes.size() < glb_start) return false;
  const std::size_t head = glb_head_size(std::as_bytes(std::span(bytes.substr(0, glb_start))));
  const std::string_view json = bytes.substr(glb_start, head - glb_start);
  return json.find('"' + std::string(asset_extension) + '"') != json.npos;
}

}  // namespace encage
