// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/tree/mesh_arrays.h"

#include <encage/shape_cache.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
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

  /// Throws Error, its message starting with `file`, if the budget has no room for both the mesh and the largest other
  /// one.
  void add(const OnDemandMesh& mesh, const std::string& file);
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

/// The fine mesh of a shape of a ShapeCache. While it is pinned, SimpleShape::fine does not change.
class ENCAGE_HIDDEN OnDemandMesh {
 public:
  /// The shape has its asset and cages, and owns this object.
  OnDemandMesh(SimpleShape& shape, std::string file, std::shared_ptr<MeshBudget> budget);
  ~OnDemandMesh();
  OnDemandMesh(const OnDemandMesh&) = delete;
  OnDemandMesh& operator=(const OnDemandMesh&) = delete;

  /// Throws Error; the mesh is then not pinned.
  void pin();
  void unpin() noexcept;
  std::int64_t owned_bytes() const { return budget_->owned_bytes(*this); }

 private:
  friend MeshBudget;
  std::int64_t load();  ///< bytes in memory; throws Error
  void drop() noexcept;

  SimpleShape& shape_;
  std::string file_;
  std::shared_ptr<MeshBudget> budget_;
  // A query first pins and then tests whether the mesh is resident; the budget first clears `resident_` and then tests
  // whether the mesh is pinned. All four operations have one total order, so at least one side sees the other.
  std::atomic<std::int64_t> pins_{0};
  std::atomic<bool> resident_{false};
  std::atomic<std::uint64_t> used_at_{0};
  // Under the budget's lock.
  std::int64_t bytes_;                // of memory; for a mesh whose tree must be built, of its sections until then
  bool checked_ = false;              // the mapped bytes match their hashes
  std::optional<MeshArrays> arrays_;  // built
};

}  // namespace encage
