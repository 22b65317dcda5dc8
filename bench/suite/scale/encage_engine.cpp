// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/scale/engine.h"

#include <encage/world.h>

namespace encage::scale {
namespace {

/// Computes the boxes from the motions itself.
class Encage : public BroadPhase {
 public:
  Encage(const ScaleScene& scene, const PairOptions& pair) {
    std::vector<ShapeId> shapes;
    for (const ShapePtr& shape : scene.shapes()) shapes.push_back(world_.add_shape(shape));
    const ScaleFrame frame = scene.frame();
    for (std::size_t n = 0; n < frame.motions.size(); ++n) {
      bodies_.push_back(world_.add_body(shapes[scene.shape_of(n)], frame.motions[n].start));
    }
    options_.pair = pair;
  }

  void step(const ScaleFrame& frame, std::vector<PairKey>& pairs) override {
    for (const std::uint32_t n : frame.moved) world_.set_motion(bodies_[n], frame.motions[n]);
    world_.find_candidates(options_,
                           [&](const CandidatePair& pair) { pairs.push_back(pair_key(index(pair.a), index(pair.b))); });
  }

 private:
  World world_;
  std::vector<BodyId> bodies_;
  CandidateOptions options_;
};

}  // namespace

std::unique_ptr<BroadPhase> make_encage(const ScaleScene& scene) {
  return std::make_unique<Encage>(scene, PairOptions{.cages = CageUse::never, .fine = false});
}
std::unique_ptr<BroadPhase> make_encage_full(const ScaleScene& scene) {
  return std::make_unique<Encage>(scene, PairOptions{});
}

}  // namespace encage::scale
