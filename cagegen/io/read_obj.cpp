// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/mesh_file.h"
#include "cagegen/io/text_scanner.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace encage::io {
namespace {

/// The vertex of "v", "v/vt", "v//vn" or "v/vt/vn": from 1, or from the end if negative.
std::int32_t read_corner(const TextScanner& scanner, std::string_view token, const Soup& soup) {
  const std::string_view vertex = token.substr(0, token.find('/'));
  const std::int64_t face = soup.polygon_count();
  if (vertex.empty()) scanner.fail("face", face, "corner without a vertex index");
  const std::int64_t index = scanner.integer(vertex, "face", face);
  if (index == 0 || index < -soup.vertex_count() || index > INT32_MAX) {
    scanner.fail("face", face,
                 "vertex index " + std::to_string(index) + " is out of range (" + std::to_string(soup.vertex_count()) +
                     " vertices so far)");
  }
  return static_cast<std::int32_t>(index > 0 ? index - 1 : soup.vertex_count() + index);
}

/// What lines begin with that neither is part of the surface nor moves it: normals, names, groups, materials, and how
/// curves and renderers proceed.
bool is_ignorable(std::string_view key) {
  static constexpr std::string_view keys[] = {
      "vn",        "vt",     "vp",     "g",      "s",        "o",        "mg",   "usemtl",
      "mtllib",    "usemap", "maplib", "bevel",  "c_interp", "d_interp", "lod",  "shadow_obj",
      "trace_obj", "ctech",  "stech",  "cstype", "deg",      "bmat",     "step", "parm",
      "trim",      "hole",   "scrv",   "sp",     "end",      "con",      "vw",   "newmtl"};
  return std::find(std::begin(keys), std::end(keys), key) != std::end(keys);
}

bool is_curve_or_surface(std::string_view key) {
  for (const std::string_view known : {"curv", "curv2", "surf", "bsp", "bzp", "cdc", "cdp", "res"}) {
    if (key == known) return true;
  }
  return false;
}

/// A line that begins like this may be half of a vertex: if it were skipped, every index after it would mean another
/// vertex. Some programs end or fill text files with the control characters NUL and SUB.
bool looks_damaged(std::string_view key) {
  const bool number = (key[0] >= '0' && key[0] <= '9') || key[0] == '-' || key[0] == '+' || key[0] == '.';
  return number || std::any_of(key.begin(), key.end(),
                               [](unsigned char c) { return (c < 0x20 && c != 0 && c != 0x1A) || c == 0x7F; });
}

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& file, std::string_view bytes) : file_(file), scanner_(file, bytes) {}

  Soup read() {
    for (std::string_view key = scanner_.token(); !key.empty(); key = scanner_.token()) {
      read_line(key);
      scanner_.skip_line();  // colours after a vertex
    }
    check_indices();
    add_notes();
    return std::move(soup_);
  }

 private:
  void read_line(std::string_view key) {
    if (key == "v") {
      read_vertex();
    } else if (key == "f" || key == "fo") {  // the second is an older name of the first
      read_face();
    } else if (key == "p") {
      ++points_;
    } else if (key == "l") {
      ++lines_;
    } else if (is_curve_or_surface(key)) {
      ++curves_;
    } else if (key == "call") {
      scanner_.fail("'call' includes another file, which is not followed; put its text here instead");
    } else if (looks_damaged(key)) {
      scanner_.fail("cannot understand " + quoted(key));
    } else if (!is_ignorable(key)) {
      if (unknown_ == 0) first_unknown_ = "the first, " + quoted(key) + ", at line " + std::to_string(scanner_.line());
      ++unknown_;
    }
  }

  void read_vertex() {
    const std::int64_t v = soup_.vertex_count();
    double point[3];
    for (double& x : point) x = scanner_.coordinate(scanner_.token_on_line(), "vertex", v);
    soup_.coordinates.insert(soup_.coordinates.end(), point, point + 3);
  }

  void read_face() {
    const std::int64_t line = scanner_.line();
    const auto begin = static_cast<std::int64_t>(soup_.corners.size());
    for (std::string_view t = scanner_.token_on_line(); !t.empty(); t = scanner_.token_on_line()) {
      soup_.corners.push_back(read_corner(scanner_, t, soup_));
    }
    const std::int64_t corners = static_cast<std::int64_t>(soup_.corners.size()) - begin;
    if (corners == 0) scanner_.fail("face", soup_.polygon_count(), "has no corners");
    if (corners < 3) {
      soup_.corners.resize(static_cast<std::size_t>(begin));
      ++small_faces_;
      return;
    }
    face_lines_.push_back(line);
    soup_.end_polygon();
  }

  /// Faces may come before their vertices.
  void check_indices() const {
    for (std::int64_t f = 0; f < soup_.polygon_count(); ++f) {
      for (std::int64_t c = soup_.first[f]; c < soup_.first[f + 1]; ++c) {
        if (soup_.corners[c] < soup_.vertex_count()) continue;
        fail(file_, "face", f,
             "line " + std::to_string(face_lines_[f]) + ": vertex index " +
                 std::to_string(std::int64_t{soup_.corners[c]} + 1) + " is out of range (" +
                 std::to_string(soup_.vertex_count()) + " vertices)");
      }
    }
  }

  void add_notes() {
    std::string skipped;
    const auto add = [&](std::int64_t count, const char* one, const char* many) {
      if (count > 0) skipped += (skipped.empty() ? "" : ", ") + counted(count, one, many);
    };
    add(points_, "point element", "point elements");
    add(lines_, "line element", "line elements");
    add(small_faces_, "face of fewer than three corners", "faces of fewer than three corners");
    add(curves_, "free-form curve or surface", "free-form curves and surfaces");
    add(unknown_, "line of unknown meaning", "lines of unknown meaning");
    if (!first_unknown_.empty()) skipped += " (" + first_unknown_ + ")";
    if (!skipped.empty()) soup_.notes.push_back("skipped: " + skipped);
    if (scanner_.found_byte_order_mark()) soup_.notes.emplace_back(byte_order_mark_note);
  }

  const std::filesystem::path& file_;
  TextScanner scanner_;
  Soup soup_;
  std::vector<std::int64_t> face_lines_;
  std::int64_t points_ = 0, lines_ = 0, small_faces_ = 0, curves_ = 0, unknown_ = 0;
  std::string first_unknown_;
};

}  // namespace

Soup read_obj(const std::filesystem::path& file, std::string_view bytes) {
  require_utf8(file, bytes);
  return ObjReader(file, bytes).read();
}

}  // namespace encage::io
