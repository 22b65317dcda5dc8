// SPDX-License-Identifier: Apache-2.0
#pragma once

// The section "index" of an asset (docs/asset.md): the part of the JSON that queries need, readable without a parser.

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

/// Name and element size of an array of a mesh, stored in the section "<mesh> <name>".
struct MeshSection {
  const char* name;
  std::size_t element_size;  ///< bytes
};
/// The arrays of every mesh, in the order of the file.
inline constexpr std::array<MeshSection, 6> mesh_sections = {
    {{"vertices", 12}, {"triangles", 12}, {"boxes", 192}, {"leaves", 16}, {"owned", 1}, {"parts", 32}}};

std::string section_name(const std::string& mesh_name, const MeshSection& section);

struct AssetIndex {
  struct Array {
    std::uint32_t before = 0;  ///< bytes from the start of the array to the start of the index
    std::uint32_t size = 0;    ///< bytes
    Hash hash;
  };
  using Mesh = std::array<Array, mesh_sections.size()>;
  static constexpr std::size_t most_meshes = 65535;

  std::uint32_t file_size = 0;  ///< bytes of the whole asset
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double fine_error = 0;
  Solid solid = Solid::closed;
  bool has_fine = false;     ///< the first mesh is then the source
  std::vector<Mesh> meshes;  ///< fine to coarse; at most most_meshes
};

/// Returns the size in bytes, a multiple of index_element_size.
std::size_t index_size(std::size_t meshes);

std::string encode_index(const AssetIndex& index);

/// Returns the bytes of the index of a whole asset, located by the asset's last bytes, without a check of their
/// content. No value if there is no index that this version of the library knows, or if the asset has another format
/// version.
std::optional<std::span<const std::byte>> find_index(std::span<const std::byte> asset);

/// Decodes the bytes that find_index() has found. Throws Error, its message starting with `file`, if the hash does not
/// match or the content is invalid. The caller checks positions and sizes of the arrays.
AssetIndex decode_index(std::span<const std::byte> bytes, const std::string& file);

}  // namespace encage
