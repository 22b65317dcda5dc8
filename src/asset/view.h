// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/asset/rules.h"
#include "src/files/file_image.h"
#include "src/tree/mesh_arrays.h"

#include <encage/asset.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace encage {

enum class SectionKind {
  cage,  ///< verified when the asset is opened
  fine,  ///< verified at first use, or when opened with Verify::all
};

const char* name(SectionKind kind) noexcept;

/// One array of an asset, 64-byte aligned.
struct AssetSection {
  std::string name;  ///< unique within the asset
  SectionKind kind = SectionKind::cage;
  std::size_t element_size = 0;      ///< bytes; the size of the section is a multiple of it
  std::span<const std::byte> bytes;  ///< not empty; points into the file's image
  Hash hash;                         ///< of the bytes, as stored in the file
};

/// The parts of an asset that are read.
enum class AssetParts {
  all,
  arrays,  ///< the arrays that queries need, from the index if there is one; without parsing JSON or a description
};

/// The properties of a hierarchy that queries need besides its meshes.
struct AssetSummary {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Solid solid = Solid::closed;
  double fine_error = 0;
};

/// An asset used in place, without parsing of its arrays (docs/asset.md). All returned views point into the file's
/// image, which keeps its address as long as the AssetView lives, even if that is moved. Any number of threads may read
/// from it at a time, except during fetch_fine() and discard_fine().
class AssetView {
 public:
  /// Throws Error naming file, section and reason. With LoadMode::copy and Verify::cages, sections of kind `fine`
  /// contain zeros until fetch_fine() reads them.
  AssetView(const std::filesystem::path& file, Verify verify, LoadMode mode = LoadMode::map,
            AssetParts parts = AssetParts::all);
  /// Reads an asset in memory, at an address divisible by 64 (asserted). The caller keeps the bytes alive; `name`
  /// stands for the file in messages.
  AssetView(std::span<const std::byte> bytes, const std::string& name, Verify verify,
            AssetParts parts = AssetParts::all);

  /// False if the asset was read from its index.
  bool has_description() const { return description_.has_value(); }
  /// Returns the hierarchy without its meshes; asserts has_description().
  const CageHierarchy& description() const;
  const AssetSummary& summary() const { return summary_; }
  std::size_t level_count() const { return cages_.size(); }
  const MeshView& cage(std::size_t level) const { return cages_[level]; }
  /// Returns the fine mesh; no value if the asset has none. Validates the arrays, in linear time, but does not verify
  /// their hashes. Throws Error.
  std::optional<MeshView> fine() const;

  /// Returns trees and derived arrays as stored; no value if the asset has none of them. Validates the arrays
  /// (check_arrays()), in linear time, but does not verify hashes. Throws Error.
  std::optional<MeshArraysView> cage_arrays(std::size_t level) const;
  std::optional<MeshArraysView> fine_arrays() const;  ///< those of fine(), which must have a value

  /// Returns Certificate::clearance of each cage, also if the asset was read from its index: parses the JSON. A file
  /// that is not mapped needs fetch_clearances() before. Throws Error.
  std::vector<double> clearances() const;
  /// Reads what clearances() needs, if the file is not mapped. Throws Error.
  void fetch_clearances();

  const std::vector<AssetSection>& sections() const { return sections_; }
  const AssetSection* find_section(std::string_view section_name) const;  ///< null if there is none
  /// Throws Error if the section's bytes do not match its hash.
  void verify_hash(const AssetSection& section) const;

  LoadMode mode() const { return image_.mode(); }
  /// Returns the size of the file's image; 0 if the bytes are the caller's.
  std::int64_t image_bytes() const noexcept { return static_cast<std::int64_t>(image_.bytes().size()); }
  std::size_t fine_vertex_count() const noexcept { return fine_ ? fine_->vertices.size() : 0; }
  std::size_t fine_triangle_count() const noexcept { return fine_ ? fine_->triangles.size() : 0; }
  /// Returns the bytes of memory of the sections of kind `fine`, gaps between them included.
  std::int64_t fine_bytes() const noexcept;
  /// Reads these sections if the file is not mapped, and opens the file again if it was closed. Throws Error.
  void fetch_fine();
  /// Calls verify_hash() for each of them.
  void verify_fine() const;
  /// Frees the memory of these sections as far as it fills whole pages. Call fetch_fine() before they are used again.
  void discard_fine() noexcept;
  /// Closes a file that is not mapped.
  void close_file() noexcept { image_.close(); }

 private:
  class Parser;
  void read(std::span<const std::byte> bytes, Verify verify, AssetParts parts);
  bool read_index(std::span<const std::byte> bytes);
  void check_index(std::span<const std::byte> bytes) const;
  void fetch_head();
  void fetch_cages();
  template <class Do>
  void for_each_fine_run(Do&& act) const;
  void parse(std::span<const std::byte> bytes, Verify verify);
  std::optional<MeshArraysView> arrays(const MeshView& mesh, const std::string& mesh_name) const;
  template <class T>
  std::span<const T> array(const std::string& section_name) const;

  FileImage image_;
  std::string name_;
  std::optional<CageHierarchy> description_;
  AssetSummary summary_;
  std::vector<AssetSection> sections_;
  std::vector<MeshView> cages_;
  std::optional<MeshView> fine_;
};

TriangleMesh copy_mesh(const MeshView& view);

/// The hierarchy with its meshes, copied out of the view. Throws Error.
CageHierarchy copy_hierarchy(const AssetView& view);

/// read_asset() from memory; `name` stands for the file in messages.
CageHierarchy decode_asset(std::string_view bytes, const std::string& name, Verify verify);

/// Whether these bytes, the start of a file up to the end of its JSON or more, are those of an asset, damaged or not,
/// and not of any other file.
bool begins_like_asset(std::string_view bytes);

}  // namespace encage
