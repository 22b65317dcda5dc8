// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "cagegen/io/text_scanner.h"

#include <string>

namespace encage::io {
namespace {

/// The vertex of "v", "v/vt", "v//vn" or "v/vt/vn": from 1, or from the end if negative.
std::int64_t read_corner(const TextScanner& scanner, std::string_view token, const Soup& soup) {
  const std::string_view vertex = token.substr(0, token.find('/'));
  const std::int64_t face = soup.polygon_count();
  if (vertex.empty()) scanner.fail("face", face, "corner without a vertex index");
  const std::int64_t index = scanner.integer(vertex, "face", face);
  if (index == 0 || index < -soup.vertex_count()) {
    scanner.fail("face", face,
                 "vertex index " + std::to_string(index) + " is out of range (" + std::to_string(soup.vertex_count()) +
                     " vertices so far)");
  }
  return index > 0 ? index - 1 : soup.vertex_count() + index;
}

}  // namespace

Soup read_obj(const std::filesystem::path& file, std::string_view bytes) {
  TextScanner scanner(file, bytes);
  Soup soup;
  std::vector<std::int64_t> lines;  // of the faces
  for (std::string_view key = scanner.token(); !key.empty(); key = scanner.token()) {
    if (key == "v") {
      const std::int64_t v = soup.vertex_count();
      double point[3];
      for (double& x : point) x = scanner.coordinate(scanner.token_on_line(), "vertex", v);
      soup.coordinates.insert(soup.coordinates.end(), point, point + 3);
    } else if (key == "f") {
      lines.push_back(scanner.line());
      for (std::string_view t = scanner.token_on_line(); !t.empty(); t = scanner.token_on_line()) {
        soup.corners.push_back(read_corner(scanner, t, soup));
      }
      const std::int64_t corners = static_cast<std::int64_t>(soup.corners.size()) - soup.first.back();
      if (corners < 3) {
        scanner.fail("face", soup.polygon_count(), "has " + std::to_string(corners) + " corners, needs at least 3");
      }
      soup.end_polygon();
    }
    scanner.skip_line();  // points, lines, curves, groups, materials, colours after a vertex
  }
  // Faces may come before their vertices.
  for (std::int64_t f = 0; f < soup.polygon_count(); ++f) {
    for (std::int64_t c = soup.first[f]; c < soup.first[f + 1]; ++c) {
      if (soup.corners[c] < soup.vertex_count()) continue;
      fail(file, "face", f,
           "line " + std::to_string(lines[f]) + ": vertex index " + std::to_string(soup.corners[c] + 1) +
               " is out of range (" + std::to_string(soup.vertex_count()) + " vertices)");
    }
  }
  return soup;
}

}  // namespace encage::io
