// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/encage_engine.h"

#include <utility>

namespace encage::replay {

EncageEngine::EncageEngine(ShapePtr shape) : shape_(std::move(shape)) {}

std::vector<BodyPair> EncageEngine::touching(const PoseStep& step, const CageGate* gate) {
  PairOptions options;
  options.boxes = false;
  options.cages = gate != nullptr;
  if (gate) options.finest_cage = options.coarsest_cage = gate->level();
  std::vector<BodyPair> pairs;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const BodyPose& body : step.bodies) boxes.push_back(world_box(*shape_, Motion::resting(body.pose)));
  for (std::size_t i = 0; i < step.bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < step.bodies.size(); ++j) {
      if (!boxes[i].intersects(boxes[j])) continue;
      const Motion a = Motion::resting(step.bodies[i].pose), b = Motion::resting(step.bodies[j].pose);
      if (separated(*shape_, a, *shape_, b, options).separated) continue;
      pairs.push_back({step.bodies[i].body, step.bodies[j].body});
    }
  }
  return pairs;
}

}  // namespace encage::replay
