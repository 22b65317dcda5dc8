// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

// What the readers of single formats share. They parse the whole file in memory and name the element and the line of
// every fault; CGAL's readers return only a bool, and let through what we must refuse (NaN in STL, an OBJ index one
// past the end, a PLY without coordinates) or lose corners (OBJ with tabs).

namespace encage::io {

/// The mesh while it is being read.
struct Soup {
  std::vector<double> coordinates;    ///< x, y, z of all vertices
  std::vector<std::int32_t> corners;  ///< of more vertices than these can number validate() refuses the mesh
  std::vector<std::int64_t> first{0};
  /// They tell the user what the reader skipped or put up with: few, short, without the file's name and a full stop.
  std::vector<std::string> notes;

  std::int64_t vertex_count() const { return static_cast<std::int64_t>(coordinates.size() / 3); }
  std::int64_t polygon_count() const { return static_cast<std::int64_t>(first.size()) - 1; }
  void end_polygon() { first.push_back(static_cast<std::int64_t>(corners.size())); }
};

/// The extension in lower case without its dot.
std::string format_of(const std::filesystem::path& file);

/// Throws Error: "file: reason" and "file: element number: reason" (numbers count from 0).
[[noreturn]] void fail(const std::filesystem::path& file, const std::string& reason);
[[noreturn]] void fail(const std::filesystem::path& file, const char* element, std::int64_t number,
                       const std::string& reason);

/// "at most this many elements can be in so many bytes": counts in headers are not trusted with memory.
std::size_t plausible_count(std::int64_t count, std::size_t bytes);

/// Refuses non-finite coordinates.
void require_finite(const std::filesystem::path& file, const Soup& soup);

/// Refuses non-finite coordinates, too few corners and indices out of range.
void validate(const std::filesystem::path& file, const Soup& soup);

/// Makes one vertex of those with equal coordinates, all of which are finite; the others keep their order.
void share_vertices(Soup& soup);

Soup read_off(const std::filesystem::path& file, std::string_view bytes);
Soup read_obj(const std::filesystem::path& file, std::string_view bytes);
Soup read_stl(const std::filesystem::path& file, std::string_view bytes);
Soup read_ply(const std::filesystem::path& file, std::string_view bytes);
Soup read_gltf(const std::filesystem::path& file, std::string_view bytes);

}  // namespace encage::io
