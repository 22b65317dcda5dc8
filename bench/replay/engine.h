// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/poses.h>

#include <string>
#include <vector>

#include "bench/replay/gate.h"

namespace encage::replay {

/// A collision engine that holds copies of one mesh. It prepares what it can when it is made. Not for
/// use by several threads.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string name() const = 0;
  /// Pairs of bodies whose surfaces touch or solids overlap at the poses of a step, sorted; found by the engine's
  /// own stages. If there is a gate, it is asked about each pair as soon as the engine's broad phase has found it.
  virtual std::vector<BodyPair> touching(const PoseStep& step, const Gate* gate) = 0;
  /// False for a gate that only asks what the engine asks itself.
  virtual bool gains_from(const Gate&) const { return true; }
};

}  // namespace encage::replay
