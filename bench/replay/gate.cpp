// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/gate.h"

#include <algorithm>
#include <utility>

namespace encage::replay {
namespace {

bool ask(const Shape& shape, const BodyPose& a, const BodyPose& b, const PairOptions& options) {
  return separated(shape, Motion::resting(a.pose), shape, Motion::resting(b.pose), options).separated;
}

}  // namespace

BodyPair make_pair(std::int32_t one, std::int32_t other) { return {std::min(one, other), std::max(one, other)}; }

CageGate::CageGate(ShapePtr shape, int level) : shape_(std::move(shape)), level_(level) {}

bool CageGate::separated(const BodyPose& a, const BodyPose& b) const {
  PairOptions options;
  options.boxes = options.fine = false;
  options.finest_cage = options.coarsest_cage = level_;
  return ask(*shape_, a, b, options);
}

FineGate::FineGate(ShapePtr shape) : shape_(std::move(shape)) {}

bool FineGate::separated(const BodyPose& a, const BodyPose& b) const {
  PairOptions options;
  options.boxes = false;
  options.cages = CageUse::never;
  return ask(*shape_, a, b, options);
}

bool PerfectGate::separated(const BodyPose& a, const BodyPose& b) const {
  return !std::binary_search(touching_.begin(), touching_.end(), make_pair(a.body, b.body));
}

}  // namespace encage::replay
