// SPDX-License-Identifier: Apache-2.0
#pragma once

// A cache for more assets than fit in memory.

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
  /// Bytes, > 0, usually a fraction of the machine's memory. Limits the memory of the fine meshes and their trees, at
  /// their size in the files. Cages do not count.
  std::int64_t budget_bytes = 0;
  /// map: queries use fine meshes in place. They count as memory while they are resident, although the system may
  /// reclaim pages of files at any time. copy: each miss reads the mesh into memory of the process and verifies its
  /// hashes.
  LoadMode mode = LoadMode::map;
};

struct ShapeCacheStatistics {
  std::int64_t resident_bytes = 0;   ///< bytes of the fine meshes in memory now
  std::int64_t peak_bytes = 0;       ///< largest resident_bytes so far
  std::int64_t resident_meshes = 0;  ///< fine meshes in memory now
  std::int64_t faults = 0;           ///< number of times that a fine mesh was brought into memory
  std::int64_t evictions = 0;        ///< number of times that one was evicted
};

/// Loads shapes whose cages stay in memory. A fine mesh is loaded when a query needs it; where room is needed, the
/// least recently used meshes that no query is reading are evicted. Shapes behave as those of load_shape(), with these
/// differences:
///
/// * CageUse::automatic tests cages first, whether a mesh is in memory or not. So only pairs that survive their cages
///   need a fine mesh. (If a body is `surface_only`, so do pairs whose cages are separated but whose box may contain
///   parts of the other body.) Answers do not depend on what is in memory.
/// * world_box() and arc_margin() bound the finest cage instead of the fine mesh.
/// * A query whose fine mesh is not in memory takes a lock, reads the file and allocates memory. If that fails,
///   separated() answers "maybe", distance() answers as for a shape without a fine mesh, and the others throw Error,
///   which names the file.
///
/// resident_bytes is within the budget whenever no query runs and no FineLease lives, and while one thread queries one
/// pair at a time. Each further thread may exceed the budget by one pair.
///
/// A cache and its shapes are thread safe; shapes may outlive their cache. With LoadMode::map, files must not be
/// overwritten or truncated while shapes live (they may be replaced or removed). With LoadMode::copy, a query fails as
/// described above if the file has changed since it was loaded.
class ShapeCache {
 public:
  /// Throws Error if the budget is not positive.
  explicit ShapeCache(const ShapeCacheOptions& options);

  /// Loads the cages. Every call makes a new shape, so load a file once. For assets of versions that stored no trees,
  /// the cages' trees are built now, and the fine mesh's tree each time it is loaded. Throws Error, which names the
  /// file, the section and the reason; also if the fine mesh and the largest one loaded so far exceed the budget
  /// together, since a query may need both at once. Where a tree has to be built, this is checked again when the mesh
  /// is loaded.
  ShapePtr load(const std::filesystem::path& file, const ShapeOptions& options = {});

  ShapeCacheStatistics statistics() const;  ///< counted since the cache was made

  /// Evicts every fine mesh that no query is reading.
  void clear() noexcept;

 private:
  LoadMode mode_;
  std::shared_ptr<MeshBudget> budget_;
};

}  // namespace encage
