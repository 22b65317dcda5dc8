// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/on_demand.h"

#include "broadphase/shape/shape.h"

#include <encage/error.h>

#include <algorithm>
#include <cassert>
#include <exception>
#include <optional>
#include <utility>

namespace encage {
namespace {

std::string in_bytes(std::int64_t count) { return std::to_string(count) + " bytes"; }

}  // namespace

// ---- MeshBudget ------------------------------------------------------------

MeshBudget::MeshBudget(std::int64_t bytes) : budget_(bytes) {
  if (bytes <= 0) throw Error("shape cache: the budget of " + in_bytes(bytes) + " is not positive");
}

void MeshBudget::add(const OnDemandMesh& mesh) {
  const std::lock_guard lock(mutex_);
  check_room(mesh.bytes_, mesh.source_->name() + ": the fine mesh needs " + in_bytes(mesh.bytes_));
  sizes_.insert(mesh.bytes_);
}

void MeshBudget::check_room(std::int64_t bytes, const std::string& need) const {
  if (bytes > budget_) throw Error(need + ", the budget is " + in_bytes(budget_));
  if (const std::int64_t largest = sizes_.empty() ? 0 : *sizes_.rbegin(); bytes > budget_ - largest) {
    throw Error(need + ", the largest other one " + in_bytes(largest) + ", a pair of them more than the budget of " +
                in_bytes(budget_));
  }
}

void MeshBudget::remove(OnDemandMesh& mesh) noexcept {
  const std::lock_guard lock(mutex_);
  const auto size = sizes_.find(mesh.bytes_);
  assert(size != sizes_.end());
  sizes_.erase(size);
  const auto at = std::find(resident_.begin(), resident_.end(), &mesh);
  if (at != resident_.end()) forget(static_cast<std::size_t>(at - resident_.begin()));
}

void MeshBudget::make_resident(OnDemandMesh& mesh) {
  const std::lock_guard lock(mutex_);
  if (mesh.resident_.load()) return;
  resident_.reserve(resident_.size() + 1);
  make_room(mesh.bytes_);
  const std::int64_t bytes = mesh.source_->load(mesh.shape_);
  if (bytes != mesh.bytes_) {  // its tree was built, which makes it larger than its size in the file
    auto own = sizes_.extract(mesh.bytes_);
    try {
      check_room(bytes, mesh.source_->name() + ": the fine mesh needs " + in_bytes(bytes) + " with its tree");
    } catch (...) {
      sizes_.insert(std::move(own));
      mesh.source_->drop(mesh.shape_);
      throw;
    }
    own.value() = mesh.bytes_ = bytes;
    sizes_.insert(std::move(own));
    make_room(bytes);
  }
  resident_.push_back(&mesh);
  mesh.resident_.store(true);
  ++counts_.faults;
  counts_.resident_bytes += mesh.bytes_;
  counts_.peak_bytes = std::max(counts_.peak_bytes, counts_.resident_bytes);
  over_.store(counts_.resident_bytes > budget_);
}

void MeshBudget::make_room() noexcept {
  const std::lock_guard lock(mutex_);
  make_room(0);
}

void MeshBudget::make_room(std::int64_t bytes) noexcept {
  while (counts_.resident_bytes > budget_ - bytes && evict_oldest()) {
  }
  over_.store(counts_.resident_bytes > budget_);
}

void MeshBudget::clear() noexcept {
  const std::lock_guard lock(mutex_);
  while (evict_oldest()) {
  }
  over_.store(counts_.resident_bytes > budget_);
}

bool MeshBudget::evict_oldest() noexcept {
  constexpr auto none = static_cast<std::size_t>(-1);
  for (;;) {
    std::size_t oldest = none;
    std::uint64_t least = 0;
    for (std::size_t i = 0; i < resident_.size(); ++i) {
      const OnDemandMesh& mesh = *resident_[i];
      const std::uint64_t used_at = mesh.used_at_.load(std::memory_order_relaxed);
      if (mesh.pins_.load() != 0 || (oldest != none && used_at >= least)) continue;
      oldest = i;
      least = used_at;
    }
    if (oldest == none) return false;
    OnDemandMesh& mesh = *resident_[oldest];
    mesh.resident_.store(false);
    if (mesh.pins_.load() != 0) {  // pinned meanwhile
      mesh.resident_.store(true);
      continue;
    }
    mesh.source_->drop(mesh.shape_);
    forget(oldest);
    ++counts_.evictions;
    return true;
  }
}

void MeshBudget::forget(std::size_t resident) noexcept {
  counts_.resident_bytes -= resident_[resident]->bytes_;
  resident_[resident] = resident_.back();
  resident_.pop_back();
}

ShapeCacheStatistics MeshBudget::statistics() const {
  const std::lock_guard lock(mutex_);
  ShapeCacheStatistics counts = counts_;
  counts.resident_meshes = static_cast<std::int64_t>(resident_.size());
  return counts;
}

std::int64_t MeshBudget::owned_bytes(const OnDemandMesh& mesh) const {
  const std::lock_guard lock(mutex_);
  return mesh.resident_.load() && !mesh.source_->is_mapped() ? mesh.bytes_ : 0;
}

// ---- OnDemandMesh ----------------------------------------------------------

OnDemandMesh::OnDemandMesh(SimpleShape& shape, std::unique_ptr<FineSource> source, std::shared_ptr<MeshBudget> budget)
    : shape_(shape), source_(std::move(source)), budget_(std::move(budget)), bytes_(source_->bytes()) {
  budget_->add(*this);
}

OnDemandMesh::~OnDemandMesh() { budget_->remove(*this); }

void OnDemandMesh::pin() {
  pins_.fetch_add(1);
  if (!resident_.load()) {
    try {
      budget_->make_resident(*this);
    } catch (...) {
      unpin();
      throw;
    }
  }
  used_at_.store(budget_->now(), std::memory_order_relaxed);
}

void OnDemandMesh::unpin() noexcept {
  pins_.fetch_sub(1);
  budget_->settle();
}

// ---- Assets ----------------------------------------------------------------

namespace {

/// A mesh that is used in place has the same value each time.
class AssetSource final : public FineSource {
 public:
  AssetSource(const SimpleShape& shape, std::string file)
      : file_(std::move(file)), mode_(shape.asset->mode()), bytes_(shape.asset->fine_bytes()) {}

  std::string name() const override { return file_; }
  std::int64_t bytes() const override { return bytes_; }
  bool is_mapped() const noexcept override { return !arrays_ && mode_ == LoadMode::map; }
  std::int64_t own_bytes() const noexcept override { return 0; }

  std::int64_t load(SimpleShape& shape) override {
    AssetView& asset = *shape.asset;
    try {
      asset.fetch_fine();
      asset.close_file();
      if (!checked_ || mode_ == LoadMode::copy) asset.verify_fine();
      if (shape.fine.empty()) {
        const MeshView mesh = *asset.fine();
        auto view = asset.fine_arrays();
        if (!view) {
          arrays_ = make_mesh_arrays(copy_mesh(mesh), file_ + ": " + fine_name);
          bytes_ = arrays_->bytes();
          view = arrays_->view();
        }
        Surface fine(*view);
        if (fine.radius > shape.frame.radius) throw Error(file_ + ": " + fine_name + ": reaches beyond the cages");
        shape.fine = fine;
        if (arrays_) asset.discard_fine();
      }
      checked_ = true;
      return bytes_;
    } catch (...) {
      asset.close_file();
      drop(shape);
      throw;
    }
  }

  void drop(SimpleShape& shape) noexcept override {
    shape.asset->discard_fine();
    if (!arrays_) return;
    shape.fine = Surface();
    arrays_.reset();
  }

 private:
  const std::string file_;
  const LoadMode mode_;
  std::int64_t bytes_;                // of a mesh whose tree must be built, those of its sections until then
  bool checked_ = false;              // the mapped bytes match their hashes
  std::optional<MeshArrays> arrays_;  // built
};

}  // namespace

std::unique_ptr<FineSource> asset_source(const SimpleShape& shape, std::string file) {
  return std::make_unique<AssetSource>(shape, std::move(file));
}

// ---- FineLease -------------------------------------------------------------

namespace {

OnDemandMesh* mesh_on_demand(const Shape& shape) {
  return shape.is_compound() ? nullptr : shape.simple().on_demand.get();
}

}  // namespace

FineLease::FineLease(const Shape& shape) {
  OnDemandMesh* const mesh = mesh_on_demand(shape);
  if (!mesh) return;
  mesh->pin();
  mesh_ = mesh;
}

bool FineLease::take(const Shape& shape) noexcept {
  if (mesh_ || !mesh_on_demand(shape)) return true;
  try {
    *this = FineLease(shape);
  } catch (const std::exception&) {
    return false;
  }
  return true;
}

void FineLease::release() noexcept {
  if (mesh_) mesh_->unpin();
}

// ---- ShapeCache ------------------------------------------------------------

ShapeCache::ShapeCache(const ShapeCacheOptions& options)
    : mode_(options.mode), budget_(std::make_shared<MeshBudget>(options.budget_bytes)) {}

ShapePtr ShapeCache::load(const std::filesystem::path& file, const ShapeOptions& options) {
  return load_cages(file, options, mode_, budget_);
}

ShapeCacheStatistics ShapeCache::statistics() const { return budget_->statistics(); }

void ShapeCache::clear() noexcept { budget_->clear(); }

}  // namespace encage
