// SPDX-License-Identifier: Apache-2.0
#pragma once

// Rules that every asset obeys. Writer and reader share them: the writer refuses whatever the reader would refuse.

#include <encage/cage.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace encage {

inline constexpr const char* asset_extension = "ENCAGE_cages";
inline constexpr int asset_version = 1;
/// Bytes. The BIN chunk ends with two hashes in hexadecimal: the first is that of everything before the BIN data, the
/// second that of the whole file up to itself.
inline constexpr std::size_t seal_size = 64;
inline constexpr std::size_t seal_hash_size = 32;

/// Checks everything but the meshes: numbers are finite and in range, levels are sorted from fine to coarse by volume.
/// Throws Error, its message starting with `file`.
void check_description(const CageHierarchy& hierarchy, const std::string& file);

/// Checks that `cap_count` does not exceed the number of triangles of the fine mesh, if there is one. Throws Error, its
/// message starting with `file`.
void check_caps(std::int64_t cap_count, std::int64_t fine_triangles, const std::string& file);

/// Name of the fine mesh in names of sections.
inline constexpr const char* fine_name = "source";
/// Returns the name of a cage in names of sections; "cage 1" is the finest.
std::string cage_name(std::size_t level);

}  // namespace encage
