// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "cagegen/io/read_assimp.h"
#include "cagegen/io/text_scanner.h"
#include "cagegen/sanitize/weld.h"
#include "src/asset/view.h"
#include "src/files/read_file.h"

#include <encage/bake.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>
#include <string_view>
#include <utility>

namespace encage {
namespace io {

namespace {

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

}  // namespace

std::string format_of(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  return lower_case(extension.empty() ? extension : extension.substr(1));
}

void fail(const std::filesystem::path& file, const std::string& reason) { throw Error(file.string() + ": " + reason); }

void fail(const std::filesystem::path& file, const char* element, std::int64_t number, const std::string& reason) {
  fail(file, element + (' ' + std::to_string(number)) + ": " + reason);
}

std::size_t plausible_count(std::int64_t count, std::size_t bytes) {
  return std::min(static_cast<std::size_t>(std::max<std::int64_t>(count, 0)), bytes);
}

void require_finite(const std::filesystem::path& file, const Soup& soup) {
  for (std::size_t i = 0; i < soup.coordinates.size(); ++i) {
    if (!std::isfinite(soup.coordinates[i])) {
      fail(file, "vertex", static_cast<std::int64_t>(i / 3), "coordinate is not finite");
    }
  }
}

void share_vertices(Soup& soup) {
  const std::vector<std::int32_t> same = weld(soup.coordinates);
  std::vector<std::int32_t> number(same.size());
  std::int32_t kept = 0;
  for (std::size_t v = 0; v < same.size(); ++v) {
    if (same[v] != static_cast<std::int32_t>(v)) {
      number[v] = number[same[v]];
      continue;
    }
    for (int k = 0; k < 3; ++k) soup.coordinates[std::size_t{3} * kept + k] = soup.coordinates[3 * v + k];
    number[v] = kept++;
  }
  soup.coordinates.resize(std::size_t{3} * kept);
  for (std::int32_t& corner : soup.corners) corner = number[corner];
}

void validate(const std::filesystem::path& file, const Soup& soup) {
  constexpr std::int64_t limit = std::numeric_limits<std::int32_t>::max();
  const std::int64_t vertices = soup.vertex_count();
  if (soup.polygon_count() == 0) {
    fail(file, "no faces (" + std::to_string(vertices) + " vertices)");
  }
  if (vertices > limit || soup.polygon_count() > limit) fail(file, "more than 2^31 - 1 vertices or faces");
  require_finite(file, soup);
  for (std::int64_t p = 0; p < soup.polygon_count(); ++p) {
    const std::int64_t corners = soup.first[p + 1] - soup.first[p];
    if (corners < 3) fail(file, "face", p, "has " + std::to_string(corners) + " corners, needs at least 3");
    for (std::int64_t c = soup.first[p]; c < soup.first[p + 1]; ++c) {
      if (soup.corners[c] < 0 || soup.corners[c] >= vertices) {
        fail(file, "face", p,
             "vertex index " + std::to_string(soup.corners[c]) + " is out of range (" + std::to_string(vertices) +
                 " vertices)");
      }
    }
  }
}

namespace {

PolygonMesh to_mesh(Soup soup) {
  PolygonMesh mesh;
  mesh.vertices = Eigen::Map<const Vertices>(soup.coordinates.data(), soup.vertex_count(), 3);
  soup.coordinates = {};
  mesh.corners = std::move(soup.corners);
  mesh.first = std::move(soup.first);
  return mesh;
}

/// An asset of ours stands for its source. Its cages are meshes of the file, but no part of the body.
Soup read_asset_source(const std::filesystem::path& file, std::string_view bytes) {
  const CageHierarchy asset = decode_asset(bytes, file.string(), Verify::all);
  const Eigen::Index count = asset.fine.triangles.rows() - asset.cap_count;
  if (count <= 0) {
    fail(file,
         "an asset of Encage that holds cages without their source (--no-source); bake the mesh that it was "
         "baked from, or write a cage as a mesh by encage export");
  }
  Soup soup;
  for (const auto& vertex : asset.fine.vertices.rowwise()) {
    for (int k = 0; k < 3; ++k) soup.coordinates.push_back(asset.origin[k] + vertex[k]);
  }
  for (const auto& triangle : asset.fine.triangles.topRows(count).rowwise()) {
    soup.corners.insert(soup.corners.end(), triangle.begin(), triangle.end());
    soup.end_polygon();
  }
  soup.notes.push_back("an asset of Encage: its source is read, as stored in float32; its " +
                       counted(static_cast<std::int64_t>(asset.levels.size()), "cage is", "cages are") + " left out");
  return soup;
}

/// glTF, as text or binary.
Soup read_gltf_or_asset(const std::filesystem::path& file, std::string_view bytes) {
  if (begins_like_asset(bytes)) return read_asset_source(file, bytes);
  if (!bytes.starts_with("glTF") && bytes.find('"' + std::string(asset_extension) + '"') != bytes.npos) {
    fail(file,
         "an asset of Encage that another program wrote as text, in which cages look like further meshes; bake "
         "the .glb that Encage wrote, or the mesh that it was baked from");
  }
  return read_gltf(file, bytes);
}

constexpr struct {
  const char* name;
  Soup (*read)(const std::filesystem::path&, std::string_view);
} formats[] = {
    {"obj", read_obj},          {"ply", read_ply}, {"stl", read_stl}, {"off", read_off}, {"gltf", read_gltf_or_asset},
    {"glb", read_gltf_or_asset}};

std::string known_formats() {
  std::string list;
  for (const auto& own : formats) list += std::string(list.empty() ? "" : " ") + own.name;
  return list;
}

/// Refuses a format that nothing reads, before anything is read.
void require_known(const std::filesystem::path& file, const std::string& format) {
  for (const auto& own : formats) {
    if (format == own.name) return;
  }
  if (!format.empty() && assimp_reads(format)) return;
  fail(file, (format.empty() ? "the name has no extension that tells the format" : "unknown format '" + format + "'") +
                 " (known: " + known_formats() + "); " + more_formats());
}

Soup read_soup(const std::filesystem::path& file, std::string_view bytes, const std::string& format) {
  require_known(file, format);
  if (bytes.empty()) fail(file, "the file is empty");
  for (const auto& own : formats) {
    if (format == own.name) return own.read(file, bytes);
  }
  return read_assimp(file, bytes, format);
}

}  // namespace
}  // namespace io

PolygonMesh decode_polygon_mesh(std::string_view bytes, const std::string& format, const std::filesystem::path& name,
                                ReadNotes* notes) {
  try {
    io::Soup soup = io::read_soup(name, bytes, io::lower_case(format));
    io::validate(name, soup);
    if (notes != nullptr) notes->insert(notes->end(), soup.notes.begin(), soup.notes.end());
    return io::to_mesh(std::move(soup));
  } catch (const std::bad_alloc&) {
    io::fail(name, "not enough memory");
  }
}

PolygonMesh read_polygon_mesh(const std::filesystem::path& file, ReadNotes* notes) {
  const std::string format = io::format_of(file);
  io::require_known(file, format);
  try {
    return decode_polygon_mesh(read_file(file), format, file, notes);
  } catch (const std::bad_alloc&) {
    io::fail(file, "not enough memory");
  }
}

}  // namespace encage
