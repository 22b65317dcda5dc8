// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/fuzz.h"

#include <encage/bake.h>

#include <errno.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace {

using encage::PolygonMesh;
using encage::TriangleMesh;
using encage::fuzz::require;

/// One object serves all targets: the program fuzz_obj reads OBJ.
const std::string format = std::string(program_invocation_short_name).substr(std::string_view("fuzz_").size());

void check(const PolygonMesh& mesh) {
  require(mesh.vertices.allFinite(), "a coordinate is not finite");
  require(mesh.polygon_count() > 0 && mesh.first[0] == 0, "no polygons");
  for (std::int64_t p = 0; p < mesh.polygon_count(); ++p) {
    const auto i = static_cast<std::size_t>(p);
    require(mesh.first[i + 1] - mesh.first[i] >= 3, "a polygon of fewer than three corners");
  }
  require(mesh.first.back() == static_cast<std::int64_t>(mesh.corners.size()), "corners that belong to no polygon");
  for (const std::int32_t corner : mesh.corners) {
    require(corner >= 0 && corner < mesh.vertices.rows(), "a vertex index is out of range");
  }
}

void check(const TriangleMesh& triangles, const PolygonMesh& polygons) {
  const auto count = static_cast<std::int64_t>(polygons.corners.size()) - 2 * polygons.polygon_count();
  require(triangles.triangles.rows() == count, "n corners are not n - 2 triangles");
  for (const std::int32_t corner : triangles.triangles.reshaped()) {
    require(corner >= 0 && corner < triangles.vertices.rows(), "a triangle's vertex index is out of range");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // No file lies beside it.
  static const std::filesystem::path name = "/nowhere/fuzz." + format;
  // A byte of glTF may mean 64 vertices and triangles (GltfDocument::plausible_size()).
  static const bool unfolds = format == "gltf" || format == "glb";
  constexpr std::int64_t unfolded = 64 * 256;
  PolygonMesh mesh;
  const auto read = [&] {
    encage::ReadNotes notes;
    mesh = encage::decode_polygon_mesh({reinterpret_cast<const char*>(data), size}, format, name, &notes);
  };
  const std::int64_t most = encage::fuzz::memory_for(size, unfolds ? 10 + unfolded : 10);
  const bool is_read = encage::fuzz::reads(most, read, name.string() + ": not enough memory");
  if (!is_read) return 0;
  check(mesh);
  constexpr std::size_t quick = 256;
  if (mesh.corners.size() <= quick) check(encage::triangulate(mesh), mesh);
  return 0;
}
