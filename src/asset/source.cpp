// SPDX-License-Identifier: Apache-2.0
#include "src/files/hash.h"

#include <encage/asset.h>

#include <cmath>
#include <limits>
#include <string>

namespace encage {
namespace {

/// True if each corner of one triangle lies within the distance from some corner of the other. Corners may have been
/// reordered by the bake, which turns surfaces inside out where their orientation is wrong.
bool same_corners(const TriangleMesh& a, const TriangleMesh& b, const Eigen::Vector3d& b_at, std::int64_t t,
                  double distance) {
  unsigned found_a = 0, found_b = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (!((a.corner(t, i) - (b_at + b.corner(t, j))).norm() <= distance)) continue;
      found_a |= 1U << i;
      found_b |= 1U << j;
    }
  }
  return found_a == 7 && found_b == 7;
}

/// Returns how the mesh differs from the fine mesh of an asset; empty if it does not.
std::string difference(const TriangleMesh& mesh, const CageHierarchy& asset) {
  if (asset.fine.triangles.rows() == 0) return "the asset stores no fine mesh to compare it with";
  const std::int64_t expected = asset.fine.triangles.rows() - asset.cap_count;
  if (mesh.triangles.rows() != expected) {
    return "it has " + std::to_string(mesh.triangles.rows()) + " triangles, the asset " + std::to_string(expected);
  }
  const std::int64_t vertices = mesh.vertices.rows();
  if (mesh.triangles.minCoeff() < 0 || mesh.triangles.maxCoeff() >= vertices) {
    return "a triangle has a vertex that is out of range (" + std::to_string(vertices) + " vertices)";
  }
  const double largest = mesh.vertices.cwiseAbs().maxCoeff();
  const double distance = asset.fine_error + 2 * std::sqrt(3.0) * largest * std::numeric_limits<float>::epsilon();
  for (std::int64_t t = 0; t < expected; ++t) {
    if (same_corners(mesh, asset.fine, asset.origin, t, distance)) continue;
    return "triangle " + std::to_string(t) + " lies elsewhere";
  }
  return {};
}

}  // namespace

void require_source(const std::filesystem::path& file, const TriangleMesh& mesh) {
  const CageHierarchy asset = read_asset(file);
  const Hash hash = hash_mesh(mesh);
  if (hash == asset.source_hash) return;
  const std::string reason = difference(mesh, asset);
  if (reason.empty()) return;
  throw Error(file.string() + ": was not baked from this mesh: " + reason + "; the source's hash is " +
              to_string(asset.source_hash) + ", the mesh's " + to_string(hash));
}

}  // namespace encage
