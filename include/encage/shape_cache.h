// SPDX-License-Identifier: Apache-2.0
#pragma once

// Run time: more assets than memory has room for.

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
  /// Memory for fine meshes with their trees, as they lie in the files, > 0. Cages are not counted.
  std::int64_t budget_bytes = 0;
  /// map: fine meshes are used in place. They count as memory while they are resident, although the system could take
  /// pages of files back at any time. copy: they are read into memory of the process, again and with their hashes
  /// verified each time.
  LoadMode mode = LoadMode::map;
};

struct ShapeCacheStatistics {
  std::int64_t resident_bytes = 0;  ///< fine meshes in memory
  std::int64_t peak_bytes = 0;      ///< the most that resident_bytes has been
  std::int64_t resident_meshes = 0;
  std::int64_t faults = 0;     ///< fine meshes that were brought into memory, each time counted
  std::int64_t evictions = 0;  ///< that were taken out of it
};

/// Loads shapes of which only the cages stay in memory; a fine mesh comes when a query needs it, and the least
/// recently used ones that no query looks at go where room is needed. Shapes behave as those of load_shape(), with
/// these differences:
///
/// * CageUse::automatic asks cages first, whatever is in memory: so a fine mesh is needed for pairs that survive their
///   cages only. (If a body is `surface_only`, also where cages are apart but its box may hold parts of the other.)
///   Answers do not depend on what is in memory.
/// * world_box() and arc_margin() bound the finest cage in place of the fine mesh.
/// * A query that finds its fine mesh missing takes a lock, reads the file and allocates memory. If it cannot,
///   separated() answers "maybe" and the others throw Error, which names the file.
///
/// Whenever no query runs and no FineLease lives, resident_bytes is within the budget; so it is while one thread
/// asks one pair at a time. Each further thread may add a pair.
///
/// Thread safe, as are its shapes, which may outlive it. With LoadMode::map files must not be overwritten or truncated
/// while shapes live (replaced or removed they may be); with LoadMode::copy a file that is not as it was loaded makes a
/// query fail as said above.
class ShapeCache {
 public:
  /// Throws Error for a budget that is not positive.
  explicit ShapeCache(const ShapeCacheOptions& options);

  /// Loads the cages. Every call makes a shape of its own: load a file once. For assets from before trees were
  /// stored, the cages' trees are built now and the fine mesh's whenever it comes. Throws Error naming file, section
  /// and reason; also if the fine mesh, together with the largest one that is loaded, exceeds the budget: a query may
  /// need both at once. Where its tree has to be built, that is asked again when it comes.
  ShapePtr load(const std::filesystem::path& file, const ShapeOptions& options = {});

  ShapeCacheStatistics statistics() const;

  /// Evicts every fine mesh that no query looks at.
  void clear() noexcept;

 private:
  LoadMode mode_;
  std::shared_ptr<MeshBudget> budget_;
};

}  // namespace encage
