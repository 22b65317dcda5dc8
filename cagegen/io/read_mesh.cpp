// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"

#include <encage/bake.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>

namespace encage {
namespace io {

void fail(const std::filesystem::path& file, const std::string& reason) { throw Error(file.string() + ": " + reason); }

void fail(const std::filesystem::path& file, const char* element, std::int64_t number, const std::string& reason) {
  fail(file, element + (' ' + std::to_string(number)) + ": " + reason);
}

std::size_t plausible_count(std::int64_t count, std::size_t bytes) {
  return std::min(static_cast<std::size_t>(std::max<std::int64_t>(count, 0)), bytes);
}

void validate(const std::filesystem::path& file, const Soup& soup) {
  constexpr std::int64_t limit = std::numeric_limits<std::int32_t>::max();
  const std::int64_t vertices = soup.vertex_count();
  if (soup.polygon_count() == 0) {
    fail(file, "no faces (" + std::to_string(vertices) + " vertices)");
  }
  if (vertices > limit || soup.polygon_count() > limit) fail(file, "more than 2^31 - 1 vertices or faces");
  for (std::size_t i = 0; i < soup.coordinates.size(); ++i) {
    if (!std::isfinite(soup.coordinates[i])) {
      fail(file, "vertex", static_cast<std::int64_t>(i / 3), "coordinate is not finite");
    }
  }
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

std::string read_file(const std::filesystem::path& file) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "rb"), std::fclose);
  if (!stream) fail(file, std::string("cannot open: ") + std::strerror(errno));
  std::string bytes;
  std::size_t size = 0;
  do {
    bytes.resize(std::max<std::size_t>(1 << 16, bytes.size() * 2));
    size += std::fread(bytes.data() + size, 1, bytes.size() - size, stream.get());
  } while (size == bytes.size());
  if (std::ferror(stream.get())) fail(file, std::string("cannot read: ") + std::strerror(errno));
  bytes.resize(size);
  return bytes;
}

PolygonMesh to_mesh(const Soup& soup) {
  PolygonMesh mesh;
  mesh.vertices = Eigen::Map<const Vertices>(soup.coordinates.data(), soup.vertex_count(), 3);
  mesh.corners.assign(soup.corners.begin(), soup.corners.end());
  mesh.first = soup.first;
  return mesh;
}

Soup read_soup(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  static constexpr struct {
    const char* extension;
    Soup (*read)(const std::filesystem::path&, std::string_view);
  } formats[] = {{".obj", read_obj}, {".ply", read_ply},   {".stl", read_stl},
                 {".off", read_off}, {".gltf", read_gltf}, {".glb", read_gltf}};
  for (const auto& format : formats) {
    if (extension != format.extension) continue;
    const std::string bytes = read_file(file);
    if (bytes.empty()) fail(file, "the file is empty");
    return format.read(file, bytes);
  }
  fail(file, "unknown extension '" + extension + "' (known: .obj .ply .stl .off .gltf .glb)");
}

}  // namespace
}  // namespace io

PolygonMesh read_polygon_mesh(const std::filesystem::path& file) {
  try {
    const io::Soup soup = io::read_soup(file);
    io::validate(file, soup);
    return io::to_mesh(soup);
  } catch (const std::bad_alloc&) {
    io::fail(file, "not enough memory");
  }
}

}  // namespace encage
