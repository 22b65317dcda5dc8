// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "src/files/read_file.h"

#include <encage/bake.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>
#include <string_view>

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

PolygonMesh to_mesh(const Soup& soup) {
  PolygonMesh mesh;
  mesh.vertices = Eigen::Map<const Vertices>(soup.coordinates.data(), soup.vertex_count(), 3);
  mesh.corners.assign(soup.corners.begin(), soup.corners.end());
  mesh.first = soup.first;
  return mesh;
}

constexpr struct {
  const char* name;
  Soup (*read)(const std::filesystem::path&, std::string_view);
} formats[] = {{"obj", read_obj}, {"ply", read_ply},   {"stl", read_stl},
               {"off", read_off}, {"gltf", read_gltf}, {"glb", read_gltf}};

std::string known_formats() {
  std::string list;
  for (const auto& format : formats) list += std::string(list.empty() ? "" : " ") + format.name;
  return list;
}

std::string lower_case(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

/// Of the format with this name.
auto find_reader(const std::filesystem::path& file, const std::string& name) {
  for (const auto& format : formats) {
    if (name == format.name) return format.read;
  }
  fail(file, name.empty() ? "the name has no extension that tells the format (known: " + known_formats() + ")"
                          : "unknown format '" + name + "' (known: " + known_formats() + ")");
}

}  // namespace
}  // namespace io

PolygonMesh decode_polygon_mesh(std::string_view bytes, const std::string& format, const std::filesystem::path& name,
                                ReadNotes* notes) {
  try {
    const auto read = io::find_reader(name, io::lower_case(format));
    if (bytes.empty()) io::fail(name, "the file is empty");
    io::Soup soup = read(name, bytes);
    io::validate(name, soup);
    if (notes != nullptr) notes->insert(notes->end(), soup.notes.begin(), soup.notes.end());
    return io::to_mesh(soup);
  } catch (const std::bad_alloc&) {
    io::fail(name, "not enough memory");
  }
}

PolygonMesh read_polygon_mesh(const std::filesystem::path& file, ReadNotes* notes) {
  const std::string extension = file.extension().string();
  const std::string format = io::lower_case(extension.substr(std::min<std::size_t>(1, extension.size())));
  io::find_reader(file, format);  // before anything is read
  try {
    return decode_polygon_mesh(read_file(file), format, file, notes);
  } catch (const std::bad_alloc&) {
    io::fail(file, "not enough memory");
  }
}

}  // namespace encage
