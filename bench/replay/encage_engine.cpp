// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/encage_engine.h"

#include "bench/common/box_pairs.h"

#include <utility>

namespace encage::replay {
namespace {

class EncageEngine : public Engine {
 public:
  explicit EncageEngine(ShapePtr shape) : shape_(std::move(shape)) {}

  std::string name() const override { return "encage"; }
  bool gains_from(const Gate& gate) const override { return dynamic_cast<const FineGate*>(&gate) == nullptr; }

  std::vector<BodyPair> touching(const StepQuestion& question) override {
    const PoseStep& step = question.step;
    PairOptions options;
    options.boxes = false;
    options.cages = CageUse::never;
    const auto* cages = dynamic_cast<const CageGate*>(question.gate);
    if (cages) {
      options.cages = CageUse::always;
      options.finest_cage = options.coarsest_cage = cages->level();
    }
    std::vector<BodyPair> pairs;
    for (const auto& [i, j] : boxes_.overlaps(*shape_, step)) {
      const BodyPose& a = step.bodies[i];
      const BodyPose& b = step.bodies[j];
      if (cages ? question.leaves_out(a, b) : question.skips(a, b)) continue;
      const Motion motion_a = Motion::resting(a.pose), motion_b = Motion::resting(b.pose);
      if (!separated(*shape_, motion_a, *shape_, motion_b, options).separated) pairs.push_back({a.body, b.body});
    }
    return pairs;
  }

 private:
  ShapePtr shape_;
  bench::BoxPairs boxes_;
};

}  // namespace

std::unique_ptr<Engine> make_encage_engine(ShapePtr shape) { return std::make_unique<EncageEngine>(std::move(shape)); }

}  // namespace encage::replay
