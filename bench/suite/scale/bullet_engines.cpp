// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/scale/engine.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

namespace encage::scale {
namespace {

btVector3 vector(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

/// In float32; pairs that the rounding adds are left out.
template <class Broadphase>
class Bullet : public BroadPhase {
 public:
  Bullet(const ScaleScene& scene, std::unique_ptr<Broadphase> broadphase) : broadphase_(std::move(broadphase)) {
    const ScaleFrame frame = scene.frame();
    for (std::size_t n = 0; n < frame.motions.size(); ++n) {
      const FloatBox& box = frame.float_box[n];
      proxies_.push_back(broadphase_->createProxy(vector(box.lower), vector(box.upper), 0,
                                                  reinterpret_cast<void*>(n),  // NOLINT: the caller's number
                                                  1, 1, nullptr));
    }
  }
  ~Bullet() override {
    for (btBroadphaseProxy* proxy : proxies_) broadphase_->destroyProxy(proxy, nullptr);
  }

  void step(const ScaleFrame& frame, std::vector<PairKey>& pairs) override {
    for (const std::uint32_t n : frame.moved) {
      const FloatBox& box = frame.float_box[n];
      broadphase_->setAabb(proxies_[n], vector(box.lower), vector(box.upper), nullptr);
    }
    broadphase_->calculateOverlappingPairs(nullptr);
    const btBroadphasePairArray& found = broadphase_->getOverlappingPairCache()->getOverlappingPairArray();
    for (int i = 0; i < found.size(); ++i) {
      const std::uint32_t a = number(found[i].m_pProxy0), b = number(found[i].m_pProxy1);
      if (overlap(frame, a, b)) pairs.push_back(pair_key(a, b));
    }
  }

 private:
  static std::uint32_t number(const btBroadphaseProxy* proxy) {
    return static_cast<std::uint32_t>(reinterpret_cast<std::size_t>(proxy->m_clientObject));
  }

  std::unique_ptr<Broadphase> broadphase_;
  std::vector<btBroadphaseProxy*> proxies_;
};

}  // namespace

std::unique_ptr<BroadPhase> make_bullet_dbvt(const ScaleScene& scene) {
  return std::make_unique<Bullet<btDbvtBroadphase>>(scene, std::make_unique<btDbvtBroadphase>());
}

std::unique_ptr<BroadPhase> make_bullet_sweep(const ScaleScene& scene) {
  const ScaleFrame frame = scene.frame();
  FloatBox all = frame.float_box.front();
  for (const FloatBox& box : frame.float_box) all = all.merged(box);
  all = all.enlarged(all.upper[0] - all.lower[0]);
  return std::make_unique<Bullet<bt32BitAxisSweep3>>(
      scene, std::make_unique<bt32BitAxisSweep3>(vector(all.lower), vector(all.upper),
                                                 static_cast<unsigned>(frame.motions.size() + 2)));
}

}  // namespace encage::scale
