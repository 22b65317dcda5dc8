// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/flow.h"

#include <cassert>

namespace encage::makers {

void FlowHistory::push(std::vector<std::int32_t> moved, std::vector<Eigen::Vector3f> positions) {
  assert(moved.size() == positions.size());
  steps_.push_back({std::move(moved), std::move(positions)});
}

void FlowHistory::append(const FlowHistory& later) {
  steps_.insert(steps_.end(), later.steps_.begin(), later.steps_.end());
}

Vertices FlowHistory::at(int step) const {
  assert(step >= 0 && step <= steps());
  Vertices result = start_;
  for (int s = 0; s < step; ++s) {
    const Step& made = steps_[s];
    for (std::size_t i = 0; i < made.moved.size(); ++i) {
      result.row(made.moved[i]) = made.positions[i].cast<double>().transpose();
    }
  }
  return result;
}

std::size_t FlowHistory::bytes() const {
  std::size_t sum = static_cast<std::size_t>(start_.size()) * sizeof(double);
  for (const Step& step : steps_) {
    sum += step.moved.capacity() * sizeof(std::int32_t) + step.positions.capacity() * sizeof(Eigen::Vector3f);
  }
  return sum;
}

}  // namespace encage::makers
