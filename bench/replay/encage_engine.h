// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"

namespace encage::replay {

/// Encage itself: boxes, the gate's cages if there is one, body-frame trees. What it cannot prove apart touches.
class EncageEngine : public Engine {
 public:
  explicit EncageEngine(ShapePtr shape);

  std::string name() const override { return "encage"; }
  std::vector<BodyPair> touching(const PoseStep& step, const CageGate* gate) override;

 private:
  ShapePtr shape_;
};

}  // namespace encage::replay
