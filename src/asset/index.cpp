// SPDX-License-Identifier: Apache-2.0
#include "src/asset/index.h"

#include "src/asset/glb.h"
#include "src/asset/rules.h"
#include "src/files/hash.h"

#include <encage/error.h>

#include <cmath>
#include <cstring>

namespace encage {
namespace {

constexpr std::array<char, 4> index_magic = {'E', 'N', 'C', 'I'};
constexpr std::uint16_t index_version = 1;

/// The last bytes of the index as stored in the file. The arrays precede it, mesh after mesh.
struct Trailer {
  std::array<char, 4> magic = index_magic;
  std::uint32_t file_size = 0;  ///< bytes of the whole asset; a file that was extended or truncated has another size
  std::uint16_t version = index_version;
  std::uint8_t solid = 0;
  std::uint8_t has_fine = 0;
  std::uint16_t meshes = 0;
  std::uint16_t asset = asset_version;
  std::array<double, 3> origin = {};
  double fine_error = 0;
  Hash hash;  ///< hash of the index up to here
};
static_assert(sizeof(Trailer) == 64 && sizeof(Hash) == 16);
static_assert(sizeof(AssetIndex::Mesh) == 144);

Hash hash_of(std::span<const std::byte> index) { return hash_bytes(index.first(index.size() - sizeof(Hash))); }

Trailer trailer_of(std::span<const std::byte> index) {
  Trailer trailer;
  std::memcpy(&trailer, index.last(sizeof trailer).data(), sizeof trailer);
  return trailer;
}

}  // namespace

std::string section_name(const std::string& mesh_name, const MeshSection& section) {
  return mesh_name + ' ' + section.name;
}

std::size_t index_size(std::size_t meshes) { return align_up(meshes * sizeof(AssetIndex::Mesh) + sizeof(Trailer)); }

std::string encode_index(const AssetIndex& index) {
  Trailer trailer;
  trailer.file_size = index.file_size;
  trailer.solid = static_cast<std::uint8_t>(index.solid);
  trailer.has_fine = index.has_fine ? 1 : 0;
  trailer.meshes = static_cast<std::uint16_t>(index.meshes.size());
  for (int k = 0; k < 3; ++k) trailer.origin[k] = index.origin[k];
  trailer.fine_error = index.fine_error;

  const std::size_t arrays = index.meshes.size() * sizeof(AssetIndex::Mesh);
  std::string bytes(index_size(index.meshes.size()) - arrays - sizeof trailer, '\0');
  bytes.append(reinterpret_cast<const char*>(index.meshes.data()), arrays);
  bytes.append(reinterpret_cast<const char*>(&trailer), sizeof trailer);
  trailer.hash = hash_of(std::as_bytes(std::span(bytes)));
  std::memcpy(bytes.data() + bytes.size() - sizeof(Hash), &trailer.hash, sizeof(Hash));
  return bytes;
}

std::optional<std::span<const std::byte>> find_index(std::span<const std::byte> asset) {
  const std::size_t file_size = asset.size();
  if (file_size < seal_size + sizeof(Trailer)) return std::nullopt;
  asset = asset.first(file_size - seal_size);
  const Trailer trailer = trailer_of(asset);
  if (trailer.magic != index_magic || trailer.version != index_version || trailer.asset != asset_version ||
      trailer.file_size != file_size) {
    return std::nullopt;
  }
  const std::size_t size = index_size(trailer.meshes);
  if (size > asset.size()) return std::nullopt;
  return asset.last(size);
}

AssetIndex decode_index(std::span<const std::byte> bytes, const std::string& file) {
  const std::string place = file + ": section \"" + index_name + "\": ";
  const Trailer trailer = trailer_of(bytes);
  if (hash_of(bytes) != trailer.hash) throw Error(place + "its hash does not match: the file is damaged");
  AssetIndex index;
  index.file_size = trailer.file_size;
  for (int k = 0; k < 3; ++k) index.origin[k] = trailer.origin[k];
  index.fine_error = trailer.fine_error;
  index.solid = static_cast<Solid>(trailer.solid);
  if (trailer.solid > static_cast<int>(Solid::surface_only)) {
    throw Error(place + "solid is " + std::to_string(trailer.solid) + ", not 0, 1 or 2");
  }
  if (trailer.has_fine > 1) {
    throw Error(place + "the mark of a source is " + std::to_string(trailer.has_fine) + ", not 0 or 1");
  }
  if (trailer.meshes == 0) throw Error(place + "it has no meshes");
  if (!index.origin.allFinite()) throw Error(place + "the origin is not finite");
  if (!(index.fine_error >= 0) || std::isinf(index.fine_error)) {
    throw Error(place + "fine_error is not a finite distance");
  }
  index.has_fine = trailer.has_fine == 1;
  index.meshes.resize(trailer.meshes);
  const std::size_t arrays = trailer.meshes * sizeof(AssetIndex::Mesh);
  std::memcpy(index.meshes.data(), bytes.last(sizeof trailer + arrays).data(), arrays);
  return index;
}

}  // namespace encage
