// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/box_pairs.h"

namespace encage::bench {

const BoxPairs::Places& BoxPairs::overlaps(const Shape& shape, const PoseStep& step) {
  boxes_.clear();
  for (const BodyPose& body : step.bodies) boxes_.push_back(world_box(shape, Motion::resting(body.pose)));
  return find();
}

const BoxPairs::Places& BoxPairs::overlaps(const Shape& shape, const std::vector<Motion>& motions) {
  boxes_.clear();
  for (const Motion& motion : motions) boxes_.push_back(world_box(shape, motion));
  return find();
}

const BoxPairs::Places& BoxPairs::find() {
  places_.clear();
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes_.size(); ++j) {
      if (boxes_[i].intersects(boxes_[j])) places_.emplace_back(i, j);
    }
  }
  return places_;
}

}  // namespace encage::bench
