// SPDX-License-Identifier: Apache-2.0
#pragma once

// The container of binary glTF 2.0 (Khronos, glTF 2.0 specification, chapter 4): a 12-byte header, a JSON chunk and a
// BIN chunk, each with an 8-byte header.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace encage {

/// Bytes. Alignment of the BIN data, and of every array in it, relative to the start of the file.
inline constexpr std::size_t asset_alignment = 64;

constexpr std::uint64_t align_up(std::uint64_t size) {
  return (size + asset_alignment - 1) / asset_alignment * asset_alignment;
}

/// Views into the bytes of a GLB file.
struct Glb {
  std::span<const std::byte> head;  ///< everything before the BIN data
  std::string_view json;            ///< including the padding behind it
  std::span<const std::byte> bin;
};

/// Bytes. Length of the start of a GLB file that includes the length of the JSON chunk.
inline constexpr std::size_t glb_start = 20;
/// Returns the number of bytes before the BIN data according to a file's first `glb_start` bytes. The number is not
/// checked.
std::size_t glb_head_size(std::span<const std::byte> start);

/// Splits a GLB file into its two chunks. Throws Error naming `file` and the reason.
Glb parse_glb(std::span<const std::byte> bytes, const std::string& file);

/// Returns everything before the BIN data: the JSON text is padded with spaces so that the data start at a multiple of
/// `asset_alignment`. Throws Error naming `file` if the file exceeds the 4 GiB that the format allows.
std::string glb_head(std::string_view json, std::uint64_t bin_size, const std::string& file);

}  // namespace encage
