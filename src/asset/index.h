// SPDX-License-Identifier: Apache-2.0
#pragma once

// The section "index" of an asset (docs/asset.md): what queries need of the JSON, without parsing it.

#include <encage/cage.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace encage {

inline constexpr const char* index_name = "index";
inline constexpr std::size_t index_element_size = 64;

/// An array of a mesh: the section "<mesh> <name>".
struct MeshSection {
  const char* name;
  std::size_t element_size;  ///< bytes
};
/// Of every mesh, in the order of the file.
inline constexpr std::array<MeshSection, 6> mesh_sections = {
    {{"vertices", 12}, {"triangles", 12}, {"boxes", 192}, {"leaves", 16}, {"owned", 1}, {"parts", 32}}};

std::string section_name(const std::string& mesh_name, const MeshSection& section);

struct AssetIndex {
  struct Array {
    std::uint32_t before = 0;  ///< bytes from its start to that of the index
    std::uint32_t size = 0;    ///< bytes
    Hash hash;
  };
  using Mesh = std::array<Array, mesh_sections.size()>;
  static constexpr std::size_t most_meshes = 65535;

  std::uint32_t file_size = 0;  ///< of the asset
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double fine_error = 0;
  Solid solid = Solid::closed;
  bool has_fine = false;     ///< the first mesh is the source
  std::vector<Mesh> meshes;  ///< fine to coarse; at most most_meshes
};

/// Bytes; a multiple of index_element_size.
std::size_t index_size(std::size_t meshes);

std::string encode_index(const AssetIndex& index);

/// The place of the index in a whole asset, as its last bytes say, right or wrong; no value if it has none that this
/// program knows, or is of another version of the format.
std::optional<std::span<const std::byte>> find_index(std::span<const std::byte> asset);

/// What find_index() has found. Throws Error, its message starting with `file`, if its hash does not match or it means
/// nothing; places and sizes of arrays are the caller's to check.
AssetIndex decode_index(std::span<const std::byte> bytes, const std::string& file);

}  // namespace encage
