// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/glb_mutator.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string_view>
#include <utility>

// libFuzzer's own mutation.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace encage::fuzz {
namespace {

constexpr std::size_t header = 12, chunk_header = 8;

std::size_t word(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

std::string word_of(std::size_t value) {
  const auto number = static_cast<std::uint32_t>(value);
  return {reinterpret_cast<const char*>(&number), sizeof number};
}

/// No value if the bytes are no such file with both chunks.
std::optional<Chunks> split(std::string_view bytes) {
  if (bytes.size() < header + 2 * chunk_header || !bytes.starts_with("glTF")) return std::nullopt;
  const std::size_t json = word(bytes, header), data = header + 2 * chunk_header + json;
  if (data > bytes.size() || word(bytes, data - chunk_header) > bytes.size() - data) return std::nullopt;
  return Chunks{std::string(bytes.substr(header + chunk_header, json)),
                std::string(bytes.substr(data, word(bytes, data - chunk_header)))};
}

/// Changes one of the chunks.
void mutate(Chunks& chunks, std::size_t max_size, unsigned seed) {
  std::string& chunk = seed % 2 == 0 ? chunks.json : chunks.bin;
  while (&chunk == &chunks.json && chunk.ends_with(' ')) chunk.pop_back();
  const std::size_t size = chunk.size(), other = chunks.json.size() + chunks.bin.size() - size;
  constexpr std::size_t padding = 256;
  const std::size_t most = max_size > other + padding ? max_size - other - padding : 0;
  chunk.resize(std::max(size, most));
  chunk.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(chunk.data()), size, chunk.size()));
}

}  // namespace

std::string join(const Chunks& chunks, std::size_t alignment) {
  std::string json = chunks.json, bin = chunks.bin;
  const std::size_t before = header + 2 * chunk_header;
  json.resize((json.size() + before + alignment - 1) / alignment * alignment - before, ' ');
  bin.resize((bin.size() + 3) / 4 * 4, '\0');
  return "glTF" + word_of(2) + word_of(before + json.size() + bin.size()) + word_of(json.size()) + "JSON" + json +
         word_of(bin.size()) + std::string("BIN\0", 4) + bin;
}

std::size_t mutate_chunk(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed,
                         std::string (*finish)(Chunks chunks)) {
  std::optional<Chunks> chunks;
  if (seed % 8 != 0) chunks = split({reinterpret_cast<const char*>(data), size});
  if (!chunks) return LLVMFuzzerMutate(data, size, max_size);
  mutate(*chunks, max_size, seed / 8);
  const std::string bytes = finish(*std::move(chunks));
  if (bytes.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}

}  // namespace encage::fuzz
