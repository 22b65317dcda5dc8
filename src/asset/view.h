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
  std::size_t element_size = 0;      ///< bytes; divides the array's
  std::span<const std::byte> bytes;  ///< not empty; into the mapped file
  Hash hash;                         ///< of the bytes, as the file says
};

/// What is read of an asset.
enum class AssetParts {
  all,
  arrays,  ///< what queries need, from the index if there is one: no JSON is parsed, there is no description
};

/// What queries need to know of a hierarchy besides its meshes.
struct AssetSummary {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Solid solid = Solid::closed;
  double fine_error = 0;
};

/// An asset used in place, without parsing of its arrays (docs/asset.md). Everything handed
/// out points into the file's image, which stays at its address as long as the view lives, wherever that is moved.
/// Safe to read from any number of threads, but for fetch_fine() and discard_fine().
class AssetView {
 public:
  /// Throws Error naming file, section and reason. With LoadMode::copy and Verify::cages, sections of kind `fine` are
  /// zeros until fetch_fine() reads them.
  AssetView(const std::filesystem::path& file, Verify verify, LoadMode mode = LoadMode::map,
            AssetParts parts = AssetParts::all);
  /// An asset that lies in memory, at an address divisible by 64 (asserted). The
  /// caller keeps the bytes alive; `name` stands for the file in messages.
  AssetView(std::span<const std::byte> bytes, const std::string& name, Verify verify,
            AssetParts parts = AssetParts::all);

  /// Whether the index was enough.
  bool has_description() const { return description_.has_value(); }
  /// The hierarchy without its meshes; has_description() asserted.
  const CageHierarchy& description() const;
  const AssetSummary& summary() const { return summary_; }
  std::size_t level_count() const { return cages_.size(); }
  const MeshView& cage(std::size_t level) const { return cages_[level]; }
  /// No value if the asset holds no fine mesh. Validates the arrays, in linear
  /// time, but does not verify their hashes. Throws Error.
  std::optional<MeshView> fine() const;

  /// Trees and what else queries need, as stored; no value if the asset has none of it. Validates
  /// the arrays (check_arrays()), in linear time, but does not verify hashes. Throws Error.
  std::optional<MeshArraysView> cage_arrays(std::size_t level) const;
  std::optional<MeshArraysView> fine_arrays() const;  ///< of fine(), which must have a value

  const std::vector<AssetSection>& sections() const { return sections_; }
  const AssetSection* find_section(std::string_view section_name) const;  ///< null if there is none
  /// Throws Error if the section's bytes do not match its hash.
  void verify_hash(const AssetSection& section) const;

  LoadMode mode() const { return image_.mode(); }
  std::size_t fine_vertex_count() const noexcept { return fine_ ? fine_->vertices.size() : 0; }
  std::size_t fine_triangle_count() const noexcept { return fine_ ? fine_->triangles.size() : 0; }
  /// Memory that the sections of kind `fine` take, and what lies between them.
  std::int64_t fine_bytes() const noexcept;
  /// Reads them, if the file is not mapped; it is opened again if it was closed. Throws Error.
  void fetch_fine();
  /// verify_hash() of each of them.
  void verify_fine() const;
  /// Gives their memory back, as far as it fills whole pages; fetch_fine() before they are used again.
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

}  // namespace encage
