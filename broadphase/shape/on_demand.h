// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/shape_cache.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace encage {

class OnDemandMesh;
class SimpleShape;

/// Keeps track of the fine meshes in memory. Thread safe.
class ENCAGE_HIDDEN MeshBudget {
 public:
  /// Throws Error if the budget is not positive.
  explicit MeshBudget(std::int64_t bytes);

  /// Throws Error, its message starting with the mesh's name, if the budget has no room for both the mesh and the
  /// largest other one.
  void add(const OnDemandMesh& mesh);
  void remove(OnDemandMesh& mesh) noexcept;

  /// Brings a pinned mesh into memory, unless it is there. Throws Error.
  void make_resident(OnDemandMesh& mesh);
  /// If the meshes exceed the budget, evicts those that were pinned when they should have been evicted.
  void settle() noexcept {
    if (over_.load()) make_room();
  }
  void clear() noexcept;

  /// Increases from call to call and so orders uses.
  std::uint64_t now() noexcept { return clock_.fetch_add(1, std::memory_order_relaxed); }
  ShapeCacheStatistics statistics() const;
  /// Returns the bytes that the mesh has allocated, not mapped.
  std::int64_t owned_bytes(const OnDemandMesh& mesh) const;

 private:
  /// Throws Error, its message starting with `need`, if there is no room for so many bytes and the largest mesh.
  void check_room(std::int64_t bytes, const std::string& need) const;
  void make_room() noexcept;
  void make_room(std::int64_t bytes) noexcept;  // requires the lock
  bool evict_oldest() noexcept;
  void forget(std::size_t resident) noexcept;

  const std::int64_t budget_;
  std::atomic<std::uint64_t> clock_{0};
  std::atomic<bool> over_{false};
  mutable std::mutex mutex_;  // guards the following members, and everything in meshes except pinning
  std::vector<OnDemandMesh*> resident_;
  std::multiset<std::int64_t> sizes_;  // of all meshes
  ShapeCacheStatistics counts_;
};

/// Where the fine mesh of a shape comes from when a query needs it. The functions that take the shape are called one at
/// a time, while no query reads its fine mesh.
class ENCAGE_HIDDEN FineSource {
 public:
  virtual ~FineSource() = default;

  virtual std::string name() const = 0;  ///< begins the messages of errors
  /// Returns the bytes of memory that the mesh takes, as far as they are known before it has been loaded.
  virtual std::int64_t bytes() const = 0;
  /// Sets SimpleShape::fine and returns the bytes of memory that the mesh takes, no less than before. Throws Error; the
  /// shape is then as it was.
  virtual std::int64_t load(SimpleShape& shape) = 0;
  virtual void drop(SimpleShape& shape) noexcept = 0;
  virtual bool is_mapped() const noexcept = 0;          ///< a mesh in memory is not allocated but mapped from a file
  virtual std::int64_t own_bytes() const noexcept = 0;  ///< of memory that the source takes itself
};

/// The fine mesh of a shape, in memory while queries need it. While it is pinned, SimpleShape::fine does not change.
class ENCAGE_HIDDEN OnDemandMesh {
 public:
  /// The shape has its cages, and owns this object.
  OnDemandMesh(SimpleShape& shape, std::unique_ptr<FineSource> source, std::shared_ptr<MeshBudget> budget);
  ~OnDemandMesh();
  OnDemandMesh(const OnDemandMesh&) = delete;
  OnDemandMesh& operator=(const OnDemandMesh&) = delete;

  /// Throws Error; the mesh is then not pinned.
  void pin();
  void unpin() noexcept;
  std::int64_t owned_bytes() const { return source_->own_bytes() + budget_->owned_bytes(*this); }
  const FineSource& source() const { return *source_; }

 private:
  friend MeshBudget;

  SimpleShape& shape_;
  std::unique_ptr<FineSource> source_;
  std::shared_ptr<MeshBudget> budget_;
  // A query first pins and then tests whether the mesh is resident; the budget first clears `resident_` and then tests
  // whether the mesh is pinned. All four operations have one total order, so at least one side sees the other.
  std::atomic<std::int64_t> pins_{0};
  std::atomic<bool> resident_{false};
  std::atomic<std::uint64_t> used_at_{0};
  std::int64_t bytes_;  // of memory, under the budget's lock
};

/// Reads the fine mesh from the shape's asset.
std::unique_ptr<FineSource> asset_source(const SimpleShape& shape, std::string file);

}  // namespace encage
