// SPDX-License-Identifier: Apache-2.0
#pragma once

// More assets than memory has room for.

#include <encage/asset.h>
#include <encage/export.h>
#include <encage/fine_lease.h>
#include <encage/separated.h>

#include <cstdint>
#include <filesystem>
#include <memory>

namespace ENCAGE_EXPORT encage {

class MeshBudget;

struct ShapeCacheOptions {
  /// Bytes, > 0: how much of the fine meshes and their trees, as they lie in the files, may be in memory. Cages do not
  /// count.
  std::int64_t budget_bytes = 0;
  /// map: queries use fine meshes in place. These count as memory while they are resident, although the system could
  /// take pages of files back at any time. copy: each fault reads the mesh into memory of the process and verifies its
  /// hashes.
  LoadMode mode = LoadMode::map;
};

struct ShapeCacheStatistics {
  std::int64_t resident_bytes = 0;   ///< of the fine meshes in memory
  std::int64_t peak_bytes = 0;       ///< the most that resident_bytes has been
  std::int64_t resident_meshes = 0;  ///< fine meshes in memory
  std::int64_t faults = 0;           ///< how often a fine mesh was brought into memory
  std::int64_t evictions = 0;        ///< how often one was taken out of it
};

/// Loads shapes whose cages stay in memory. A fine mesh comes when a query needs it; where room is needed, the least
/// recently used ones go that no query looks at. Shapes behave as those of load_shape(), with these differences:
///
/// * CageUse::automatic asks cages first, whatever is in memory. So only pairs that survive their cages need a fine
///   mesh. (If a body is `surface_only`, also pairs whose cages are apart but where its box may hold parts of the other
///   body.) Answers do not depend on what is in memory.
/// * world_box() and arc_margin() bound the finest cage instead of the fine mesh.
/// * A query that finds its fine mesh missing takes a lock, reads the file and allocates memory. If it cannot,
///   separated() answers "maybe", distance() answers as for a shape without a fine mesh, and the others throw Error,
///   which names the file.
///
/// Whenever no query runs and no FineLease lives, resident_bytes is within the budget; also while one thread asks about
/// one pair at a time. Each further thread may add a pair.
///
/// A cache and its shapes are thread safe; shapes may outlive their cache. With LoadMode::map, files must not be
/// overwritten or truncated while shapes live (they may be replaced or removed). With LoadMode::copy, a file that has
/// changed since it was loaded makes a query fail as said above.
class ShapeCache {
 public:
  /// Throws Error if the budget is not positive.
  explicit ShapeCache(const ShapeCacheOptions& options);

  /// Loads the cages. Every call makes a shape of its own, so load a file once. For assets from before trees were
  /// stored, the cages' trees are built now, and the fine mesh's whenever it comes. Throws Error, which names the file,
  /// the section and the reason; also if the fine mesh and the largest one loaded so far exceed the budget together,
  /// since a query may need both at once. Where a tree has to be built, this is checked again when the mesh comes.
  ShapePtr load(const std::filesystem::path& file, const ShapeOptions& options = {});

  ShapeCacheStatistics statistics() const;  ///< since the cache was made

  /// Evicts every fine mesh that no query looks at.
  void clear() noexcept;

 private:
  LoadMode mode_;
  std::shared_ptr<MeshBudget> budget_;
};

}  // namespace encage
