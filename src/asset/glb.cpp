// SPDX-License-Identifier: Apache-2.0
#include "src/asset/glb.h"

#include <encage/error.h>

#include <bit>
#include <cstring>
#include <limits>

namespace encage {
namespace {

static_assert(std::endian::native == std::endian::little, "glTF is little-endian and arrays are used in place");

constexpr std::uint32_t glb_magic = 0x46546C67;   // "glTF"
constexpr std::uint32_t json_chunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t bin_chunk = 0x004E4942;   // "BIN\0"
constexpr std::size_t file_header_size = 12;
constexpr std::size_t chunk_header_size = 8;

std::uint32_t word(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

void append(std::string& bytes, std::uint32_t value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Returns the data of the chunk whose header is at `offset`.
std::span<const std::byte> chunk(std::span<const std::byte> bytes, std::size_t offset, std::uint32_t type,
                                 const std::string& where) {
  if (bytes.size() - offset < chunk_header_size) throw Error(where + ": missing: the file ends before it");
  if (word(bytes, offset + 4) != type) throw Error(where + ": missing: a chunk of another type is in its place");
  const std::size_t size = word(bytes, offset);
  if (size % 4 != 0) throw Error(where + ": its length " + std::to_string(size) + " is no multiple of 4");
  const std::size_t left = bytes.size() - offset - chunk_header_size;
  if (size > left) {
    throw Error(where + ": its length " + std::to_string(size) + " exceeds the " + std::to_string(left) +
                " bytes left in the file");
  }
  return bytes.subspan(offset + chunk_header_size, size);
}

}  // namespace

std::size_t glb_head_size(std::span<const std::byte> start) {
  if (start.size() < glb_start) return start.size();
  return glb_start + word(start, file_header_size) + chunk_header_size;
}

Glb parse_glb(std::span<const std::byte> bytes, const std::string& file) {
  const std::string header = file + ": GLB header: ";
  if (bytes.size() < file_header_size) {
    throw Error(header + "the file has only " + std::to_string(bytes.size()) + " bytes");
  }
  if (word(bytes, 0) != glb_magic) throw Error(header + "not a binary glTF file");
  if (word(bytes, 4) != 2) throw Error(header + "glTF version " + std::to_string(word(bytes, 4)) + " is not 2");
  if (word(bytes, 8) != bytes.size()) {
    throw Error(header + "the length " + std::to_string(word(bytes, 8)) + " is not the file's " +
                std::to_string(bytes.size()) + " bytes");
  }
  const auto json = chunk(bytes, file_header_size, json_chunk, file + ": JSON chunk");
  const std::size_t json_end = file_header_size + chunk_header_size + json.size();
  const auto bin = chunk(bytes, json_end, bin_chunk, file + ": BIN chunk");
  const std::size_t bin_start = json_end + chunk_header_size;
  if (bin_start + bin.size() != bytes.size()) throw Error(file + ": BIN chunk: data follow it");
  return {
      .head = bytes.first(bin_start), .json = {reinterpret_cast<const char*>(json.data()), json.size()}, .bin = bin};
}

std::string glb_head(std::string_view json, std::uint64_t bin_size, const std::string& file) {
  const std::uint64_t head_size = align_up(file_header_size + chunk_header_size + json.size() + chunk_header_size);
  const std::uint64_t size = head_size + bin_size;
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(file + ": " + std::to_string(size) + " bytes exceed the 4 GiB that a GLB file can hold");
  }
  const std::uint64_t json_size = head_size - file_header_size - 2 * chunk_header_size;
  std::string head;
  head.reserve(head_size);
  append(head, glb_magic);
  append(head, 2);
  append(head, static_cast<std::uint32_t>(size));
  append(head, static_cast<std::uint32_t>(json_size));
  append(head, json_chunk);
  head += json;
  head.append(json_size - json.size(), ' ');
  append(head, static_cast<std::uint32_t>(bin_size));
  append(head, bin_chunk);
  return head;
}

}  // namespace encage
