// SPDX-License-Identifier: Apache-2.0
#pragma once

// The container of binary glTF 2.0 (Khronos, glTF 2.0 specification, chapter 4):
// a 12-byte header, a JSON chunk and a BIN chunk, each with an 8-byte header.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace encage {

/// Alignment of the BIN data, and of every array in it, from the file's start.
inline constexpr std::size_t asset_alignment = 64;

constexpr std::uint64_t align_up(std::uint64_t size) {
  return (size + asset_alignment - 1) / asset_alignment * asset_alignment;
}

/// Views into the bytes of a GLB file.
struct Glb {
  std::span<const std::byte> head;  ///< everything before the BIN data
  std::string_view json;            ///< with the padding behind it
  std::span<const std::byte> bin;
};

/// The first bytes of a GLB file, which say how long the JSON chunk is.
inline constexpr std::size_t glb_start = 20;
/// Bytes before the BIN data as a file's first `glb_start` ones say, right or wrong.
std::size_t glb_head_size(std::span<const std::byte> start);

/// Splits a GLB file into its two chunks. Throws Error naming `file` and the reason.
Glb parse_glb(std::span<const std::byte> bytes, const std::string& file);

/// Everything before the BIN data: the JSON text is padded with spaces so that
/// the data start at a multiple of `asset_alignment`. Throws Error naming `file`
/// if the whole exceeds the 4 GiB that a GLB file can hold.
std::string glb_head(std::string_view json, std::uint64_t bin_size, const std::string& file);

}  // namespace encage
