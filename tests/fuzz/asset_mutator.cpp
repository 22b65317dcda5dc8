// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/glb.h"
#include "src/asset/index.h"
#include "src/asset/rules.h"
#include "src/files/hash.h"
#include "tests/fuzz/glb_mutator.h"

#include <nlohmann/json.hpp>

#include <cstring>
#include <span>
#include <string>

namespace encage::fuzz {
namespace {

std::span<const std::byte> span_of(const std::string& bytes) { return std::as_bytes(std::span(bytes)); }

// Another type than that of the loader, whose functions have to be those that are watched.
using Json = nlohmann::ordered_json;

/// The number that a member holds; SIZE_MAX if it holds no such.
std::size_t number(const Json& object, const char* member) {
  if (!object.is_object()) return SIZE_MAX;
  const auto found = object.find(member);
  return found == object.end() || !found->is_number_unsigned() ? SIZE_MAX : found->get<std::size_t>();
}

/// The same JSON with the hashes of the sections as they are now. What is no JSON stays as it is.
std::string with_section_hashes(const std::string& text, const std::string& bin) {
  Json json = Json::parse(text, nullptr, false);
  const Json::json_pointer sections("/extensions/ENCAGE_cages/sections"), views("/bufferViews");
  if (!json.is_object() || !json.contains(sections) || !json.contains(views)) return text;
  if (!json[sections].is_array() || !json[views].is_array()) return text;
  for (Json& section : json[sections]) {
    const std::size_t v = number(section, "bufferView");
    if (v >= json[views].size()) continue;
    const std::size_t offset = number(json[views][v], "byteOffset"), size = number(json[views][v], "byteLength");
    if (offset > bin.size() || size > bin.size() - offset) continue;
    section["hash"] = to_string(hash_bytes(span_of(bin).subspan(offset, size)));
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Writes the hashes of the arrays, and that of the index, into the index of an asset of so many bytes. The JSON has
/// the hash of the index, too.
void rehash_index(Chunks& chunks, std::size_t file_size) {
  // The last 64 bytes of the index (docs/asset.md): at 4 the size of the file, at 12 the number of meshes, at 48 the
  // hash of the index up to there.
  constexpr std::size_t trailer = 64;
  std::string& bin = chunks.bin;
  if (bin.size() < seal_size + trailer) return;
  const std::size_t end = bin.size() - seal_size, last = end - trailer;
  if (bin.compare(last, 4, "ENCI") != 0) return;
  std::uint16_t meshes = 0;
  std::memcpy(&meshes, bin.data() + last + 12, sizeof meshes);
  const std::size_t size = index_size(meshes), entries = std::size_t{meshes} * mesh_sections.size();
  if (size > end) return;
  const std::size_t start = end - size;
  const auto hash_of_index = [&] { return to_string(hash_bytes(span_of(bin).subspan(start, size))); };
  const std::string before = hash_of_index();
  const auto size32 = static_cast<std::uint32_t>(file_size);
  std::memcpy(bin.data() + last + 4, &size32, sizeof size32);
  for (std::size_t a = 0; a < entries; ++a) {
    char* const entry = bin.data() + last - (entries - a) * sizeof(AssetIndex::Array);
    AssetIndex::Array array;
    std::memcpy(&array, entry, sizeof array);
    if (array.before > start || array.size > array.before) continue;
    array.hash = hash_bytes(span_of(bin).subspan(start - array.before, array.size));
    std::memcpy(entry, &array, sizeof array);
  }
  const Hash hash = hash_bytes(span_of(bin).subspan(start, size - sizeof(Hash)));
  std::memcpy(bin.data() + end - sizeof hash, &hash, sizeof hash);
  const std::size_t at = chunks.json.find(before);
  if (at != std::string::npos) chunks.json.replace(at, before.size(), hash_of_index());
}

/// The asset with every hash right, as an attacker would write it: else every change is refused as damage.
std::string seal(Chunks chunks) {
  if (chunks.bin.size() < seal_size) return join(chunks, asset_alignment);
  chunks.bin.resize((chunks.bin.size() + 3) / 4 * 4, '\0');
  chunks.json = with_section_hashes(chunks.json, chunks.bin);
  rehash_index(chunks, join(chunks, asset_alignment).size());
  std::string bytes = join(chunks, asset_alignment);
  const std::size_t bin = bytes.size() - chunks.bin.size();
  bytes.replace(bytes.size() - seal_size, seal_hash_size, to_string(hash_bytes(span_of(bytes).first(bin))));
  bytes.replace(bytes.size() - seal_hash_size, seal_hash_size,
                to_string(hash_bytes(span_of(bytes).first(bytes.size() - seal_hash_size))));
  return bytes;
}

}  // namespace
}  // namespace encage::fuzz

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  return encage::fuzz::mutate_chunk(data, size, max_size, seed, encage::fuzz::seal);
}
