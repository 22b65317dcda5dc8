// SPDX-License-Identifier: Apache-2.0
#pragma once

// What every asset must fulfil: the writer refuses what the reader would refuse.

#include <encage/cage.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace encage {

inline constexpr const char* asset_extension = "ENCAGE_cages";
inline constexpr int asset_version = 1;
/// The last bytes of the BIN chunk: two hashes in hexadecimal, the first of
/// everything before the BIN data, the second of the whole file up to itself.
inline constexpr std::size_t seal_size = 64;
inline constexpr std::size_t seal_hash_size = 32;

/// A mesh as it lies in the file.
struct MeshView {
  std::span<const std::array<float, 3>> vertices;
  std::span<const std::array<std::uint32_t, 3>> triangles;
};

/// Everything but the meshes: numbers finite and in range, levels fine to
/// coarse by volume. Throws Error, its message starting with `file`.
void check_description(const CageHierarchy& hierarchy, const std::string& file);

/// Not empty, vertices finite, indices in range. Throws Error, its message
/// starting with `place`.
void check_mesh(const MeshView& mesh, const std::string& place);

/// `cap_count` does not exceed the triangles of the fine mesh, if there is one.
void check_caps(std::int64_t cap_count, std::int64_t fine_triangles, const std::string& file);

/// Of the fine mesh, in names of sections.
inline constexpr const char* fine_name = "source";
/// "cage 1" is the finest.
std::string cage_name(std::size_t level);

}  // namespace encage
