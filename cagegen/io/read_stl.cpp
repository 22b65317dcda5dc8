// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "cagegen/io/text_scanner.h"
#include "cagegen/sanitize/weld.h"

#include <cmath>
#include <cstring>
#include <string>

namespace encage::io {
namespace {

constexpr std::size_t header_size = 84;
constexpr std::size_t record_size = 50;

bool is_word(std::string_view token, std::string_view lower) {
  if (token.size() != lower.size()) return false;
  for (std::size_t i = 0; i < token.size(); ++i) {
    if ((token[i] | 0x20) != lower[i]) return false;
  }
  return true;
}

/// Binary files may begin with "solid" as well: the size tells, then a zero byte.
bool is_binary(std::string_view bytes) {
  if (bytes.size() >= header_size) {
    std::uint32_t count;
    std::memcpy(&count, bytes.data() + 80, 4);
    if (bytes.size() == header_size + record_size * count) return true;
  }
  const std::size_t begin = bytes.find_first_not_of(" \t\r\n");
  if (begin == bytes.npos || !is_word(bytes.substr(begin, 5), "solid")) return true;
  return bytes.substr(0, 1024).find('\0') != bytes.npos;
}

void read_binary(const std::filesystem::path& file, std::string_view bytes, Soup& soup) {
  if (bytes.size() < header_size) fail(file, "not an STL file: too short for a header");
  std::uint32_t count;
  std::memcpy(&count, bytes.data() + 80, 4);
  const std::size_t present = (bytes.size() - header_size) / record_size;
  if (present != count) {
    fail(file,
         "the header promises " + std::to_string(count) + " triangles, the file holds " + std::to_string(present));
  }
  soup.coordinates.reserve(present * 9);
  for (std::size_t t = 0; t < present; ++t) {
    float corners[9];
    std::memcpy(corners, bytes.data() + header_size + t * record_size + 12, sizeof corners);
    for (const float x : corners) {
      if (!std::isfinite(x)) fail(file, "face", static_cast<std::int64_t>(t), "coordinate is not finite");
      soup.coordinates.push_back(x);
    }
  }
}

void read_facet(TextScanner& scanner, std::int64_t face, Soup& soup) {
  const auto expect = [&](std::string_view word) {
    const std::string_view token = scanner.token();
    if (token.empty()) scanner.fail("face", face, "the file ends early");
    if (!is_word(token, word)) scanner.fail("face", face, "expected '" + std::string(word) + "'");
  };
  scanner.skip_line();  // normal
  expect("outer");
  expect("loop");
  for (int corner = 0; corner < 3; ++corner) {
    expect("vertex");
    for (int k = 0; k < 3; ++k) soup.coordinates.push_back(scanner.coordinate(scanner.token(), "face", face));
  }
  expect("endloop");
  expect("endfacet");
}

void read_ascii(const std::filesystem::path& file, std::string_view bytes, Soup& soup) {
  TextScanner scanner(file, bytes);
  bool in_solid = false;
  std::int64_t face = 0;
  for (std::string_view token = scanner.token(); !token.empty(); token = scanner.token()) {
    if (!in_solid && is_word(token, "solid")) {
      in_solid = true;
      scanner.skip_line();
    } else if (in_solid && is_word(token, "endsolid")) {
      in_solid = false;
      scanner.skip_line();
    } else if (in_solid && is_word(token, "facet")) {
      read_facet(scanner, face++, soup);
    } else {
      scanner.fail(in_solid ? "expected 'facet' or 'endsolid'" : "expected 'solid'");
    }
  }
  if (in_solid) scanner.fail("the file ends early: 'endsolid' is missing");
}

/// STL repeats every vertex in each of its triangles.
void share_vertices(Soup& soup) {
  const std::vector<std::int32_t> same = weld(soup.coordinates);
  std::vector<std::int64_t> number(same.size());
  std::int64_t kept = 0;
  for (std::size_t v = 0; v < same.size(); ++v) {
    if (same[v] == static_cast<std::int32_t>(v)) {
      for (int k = 0; k < 3; ++k) soup.coordinates[3 * kept + k] = soup.coordinates[3 * v + k];
      number[v] = kept++;
    } else {
      number[v] = number[same[v]];
    }
    soup.corners.push_back(number[v]);
    if (v % 3 == 2) soup.end_polygon();
  }
  soup.coordinates.resize(3 * kept);
}

}  // namespace

Soup read_stl(const std::filesystem::path& file, std::string_view bytes) {
  Soup soup;
  if (is_binary(bytes)) {
    read_binary(file, bytes, soup);
  } else {
    read_ascii(file, bytes, soup);
  }
  if (soup.vertex_count() > INT32_MAX) fail(file, "more than 2^31 - 1 corners");
  share_vertices(soup);
  return soup;
}

}  // namespace encage::io
