// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/mesh_shape.h"

#include "src/mesh/rounding.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <cmath>
#include <string>
#include <utility>

namespace encage::replay {
namespace {

/// What bake() would store as the fine level, without any cage.
CageHierarchy fine_only(const SourceMesh& source) {
  CageHierarchy hierarchy;
  hierarchy.origin = source.origin;
  hierarchy.solid = source.solid;
  hierarchy.source_hash = source.hash;
  hierarchy.source_volume = source.volume;
  hierarchy.diagonal = source.diagonal;
  hierarchy.cap_count = source.cap_count;
  hierarchy.fine = source.obstacle;
  hierarchy.fine_error = round_vertices(hierarchy.fine);
  return hierarchy;
}

}  // namespace

ReplayBody load_body(const std::filesystem::path& mesh, const std::filesystem::path& cages) {
  const SourceMesh source = [&] {
    const TriangleMesh read = triangulate(read_polygon_mesh(mesh));
    try {
      return sanitize(read);
    } catch (const Error& error) {
      throw Error(mesh.string() + ": " + error.what());
    }
  }();
  ReplayBody body;
  body.mesh = source.obstacle;
  body.mesh.vertices.rowwise() += source.origin.transpose();
  const CageHierarchy hierarchy = cages.empty() ? fine_only(source) : read_asset(cages, Verify::all);
  if (hierarchy.source_hash != source.hash)
    throw Error(cages.string() + ": holds cages of another mesh than " + mesh.string());
  if (hierarchy.fine.triangles.rows() == 0) throw Error(cages.string() + ": holds no fine mesh");
  body.shape = make_shape(hierarchy);
  body.closed = source.solid != Solid::surface_only;
  body.levels = static_cast<int>(hierarchy.levels.size());
  return body;
}

}  // namespace encage::replay
