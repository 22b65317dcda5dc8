// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/scale/engine.h"

#include <fcl/broadphase/broadphase_SSaP.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree_array.h>
#include <fcl/broadphase/broadphase_spatialhash.h>
#include <fcl/geometry/shape/box.h>

#include <deque>

namespace encage::scale {
namespace {

/// Has the box that it is told to have.
class BoxObject : public fcl::CollisionObjectd {
 public:
  BoxObject(const std::shared_ptr<fcl::CollisionGeometryd>& geometry, std::uint32_t number)
      : CollisionObject(geometry), number_(number) {}
  void set(const Eigen::AlignedBox3d& box) {
    aabb.min_ = box.min();
    aabb.max_ = box.max();
  }
  std::uint32_t number() const { return number_; }

 private:
  std::uint32_t number_;
};

class Fcl : public BroadPhase {
 public:
  using Manager = fcl::BroadPhaseCollisionManagerd;

  Fcl(const ScaleScene& scene, std::unique_ptr<Manager> manager) : manager_(std::move(manager)) {
    const auto geometry = std::make_shared<fcl::Boxd>(1, 1, 1);
    const ScaleFrame frame = scene.frame();
    std::vector<fcl::CollisionObjectd*> all;
    for (std::size_t n = 0; n < frame.motions.size(); ++n) {
      objects_.emplace_back(geometry, static_cast<std::uint32_t>(n)).set(frame.box[n]);
      all.push_back(&objects_.back());
    }
    manager_->registerObjects(all);
    manager_->setup();
  }

  void step(const ScaleFrame& frame, std::vector<PairKey>& pairs) override {
    for (const std::uint32_t n : frame.moved) objects_[n].set(frame.box[n]);
    // Few are taken out and put back; otherwise the whole is refitted and balanced.
    if (2 * frame.moved.size() < objects_.size()) {
      moved_.clear();
      for (const std::uint32_t n : frame.moved) moved_.push_back(&objects_[n]);
      manager_->update(moved_);
    } else {
      manager_->update();
    }
    BoxQuery query{frame, pairs};
    manager_->collide(&query, visit);
  }

 private:
  struct BoxQuery {
    const ScaleFrame& frame;
    std::vector<PairKey>& pairs;
  };

  static bool visit(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data) {
    const BoxQuery& query = *static_cast<BoxQuery*>(data);
    const std::uint32_t i = static_cast<const BoxObject*>(a)->number(), j = static_cast<const BoxObject*>(b)->number();
    if (overlap(query.frame, i, j)) query.pairs.push_back(pair_key(i, j));
    return false;
  }

  std::unique_ptr<Manager> manager_;
  std::deque<BoxObject> objects_;
  std::vector<fcl::CollisionObjectd*> moved_;
};

template <class Manager>
std::unique_ptr<BroadPhase> make(const ScaleScene& scene) {
  return std::make_unique<Fcl>(scene, std::make_unique<Manager>());
}

}  // namespace

std::unique_ptr<BroadPhase> make_fcl_tree(const ScaleScene& scene) {
  return make<fcl::DynamicAABBTreeCollisionManagerd>(scene);
}
std::unique_ptr<BroadPhase> make_fcl_tree_array(const ScaleScene& scene) {
  return make<fcl::DynamicAABBTreeCollisionManager_Arrayd>(scene);
}
std::unique_ptr<BroadPhase> make_fcl_ssap(const ScaleScene& scene) { return make<fcl::SSaPCollisionManagerd>(scene); }

std::unique_ptr<BroadPhase> make_fcl_hash(const ScaleScene& scene) {
  const ScaleFrame frame = scene.frame();
  Eigen::AlignedBox3d all;
  double size = 0;
  for (const Eigen::AlignedBox3d& box : frame.box) {
    all.extend(box);
    size += box.sizes().mean() / static_cast<double>(frame.box.size());
  }
  using Manager = fcl::SpatialHashingCollisionManager<double>;
  // Cells as large as a body, as many slots as bodies.
  return std::make_unique<Fcl>(
      scene, std::make_unique<Manager>(size, all.min(), all.max(), static_cast<unsigned>(2 * frame.box.size())));
}

}  // namespace encage::scale
