// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "cagegen/io/text_scanner.h"

#include <string>

namespace encage::io {
namespace {

/// The prefixes of Geomview's OFF that matter to us; the rest of a line (normals, colours, texture) is skipped.
struct OffHeader {
  bool homogeneous = false;
  std::int64_t vertices = 0;
  std::int64_t faces = 0;
};

std::int64_t read_count(TextScanner& scanner, std::string_view token, const char* what) {
  std::int64_t count = 0;
  if (!parse_integer(token, count) || count < 0) scanner.fail(std::string("expected the number of ") + what);
  return count;
}

OffHeader read_header(TextScanner& scanner) {
  OffHeader header;
  std::string_view token = scanner.token();
  if (token.ends_with("OFF")) {  // the keyword may be missing
    std::string_view prefix = token.substr(0, token.size() - 3);
    for (const std::string_view part : {"ST", "C", "N", "4", "n"}) {
      if (!prefix.starts_with(part)) continue;
      prefix.remove_prefix(part.size());
      if (part == "4") header.homogeneous = true;
      if (part == "n") scanner.fail("meshes of other than three dimensions (nOFF) are not supported");
    }
    if (!prefix.empty()) scanner.fail("not an OFF file");
    token = scanner.token();
    if (token == "BINARY") scanner.fail("binary OFF is not supported");
  } else if (std::int64_t number = 0; !parse_integer(token, number)) {
    scanner.fail("not an OFF file");
  }
  header.vertices = read_count(scanner, token, "vertices");
  header.faces = read_count(scanner, scanner.token(), "faces");
  scanner.skip_line();  // number of edges: often missing, never right
  return header;
}

}  // namespace

Soup read_off(const std::filesystem::path& file, std::string_view bytes) {
  require_utf8(file, bytes);
  TextScanner scanner(file, bytes);
  const OffHeader header = read_header(scanner);
  Soup soup;
  soup.coordinates.reserve(plausible_count(header.vertices, bytes.size() / 6) * 3);
  soup.first.reserve(plausible_count(header.faces, bytes.size() / 8) + 1);
  for (std::int64_t v = 0; v < header.vertices; ++v) {
    double point[4] = {0, 0, 0, 1};
    for (int k = 0; k < (header.homogeneous ? 4 : 3); ++k) {
      point[k] = scanner.coordinate(scanner.token(), "vertex", v);
    }
    for (int k = 0; k < 3; ++k) soup.coordinates.push_back(point[k] / point[3]);
    scanner.skip_line();
  }
  for (std::int64_t f = 0; f < header.faces; ++f) {
    const std::int64_t corners = scanner.integer(scanner.token(), "face", f);
    if (corners < 3) scanner.fail("face", f, "has " + std::to_string(corners) + " corners, needs at least 3");
    for (std::int64_t c = 0; c < corners; ++c) {
      const std::int64_t index = scanner.integer(scanner.token(), "face", f);
      if (index < 0 || index >= header.vertices) {
        scanner.fail("face", f,
                     "vertex index " + std::to_string(index) + " is out of range (" + std::to_string(header.vertices) +
                         " vertices)");
      }
      soup.corners.push_back(static_cast<std::int32_t>(index));
    }
    soup.end_polygon();
    scanner.skip_line();
  }
  if (!scanner.token().empty()) {
    soup.notes.push_back("skipped: the file goes on, at line " + std::to_string(scanner.line()) + ", after the " +
                         std::to_string(header.faces) + " faces that its header promises");
  }
  if (scanner.found_byte_order_mark()) soup.notes.emplace_back(byte_order_mark_note);
  return soup;
}

}  // namespace encage::io
