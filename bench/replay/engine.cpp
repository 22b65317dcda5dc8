// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/engine.h"

#include <utility>

namespace encage::replay {

CageGate::CageGate(ShapePtr shape, int level) : shape_(std::move(shape)), level_(level) {}

bool CageGate::separated(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
  PairOptions options;
  options.finest_cage = options.coarsest_cage = level_;
  options.fine = false;
  return encage::separated(*shape_, Motion::resting(a), *shape_, Motion::resting(b), options).separated;
}

}  // namespace encage::replay
