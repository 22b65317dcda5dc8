// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/gate.h"

#include <encage/poses.h>

#include <string>
#include <vector>

namespace encage::replay {

/// What an engine is asked.
struct StepQuestion {
  const PoseStep& step;
  const Gate* gate = nullptr;                            ///< none: the engine alone
  const std::vector<BodyPair>* not_asked_for = nullptr;  ///< sorted pairs that are no pairs in this step

  bool leaves_out(const BodyPose& a, const BodyPose& b) const;
  /// For engines to ask about each pair as soon as their broad phase has found it: not asked for, or rejected.
  bool skips(const BodyPose& a, const BodyPose& b) const {
    return leaves_out(a, b) || (gate != nullptr && gate->separated(a, b));
  }
};

/// A collision engine that holds copies of one mesh. It prepares what it can when it is made. Not for use by several
/// threads.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string name() const = 0;
  /// Pairs of bodies whose surfaces touch or solids overlap at the poses of a step, sorted; without those that the
  /// question skips; found by the engine's own stages.
  virtual std::vector<BodyPair> touching(const StepQuestion& question) = 0;
  /// False for a gate that only asks what the engine asks itself.
  virtual bool gains_from(const Gate&) const { return true; }
};

}  // namespace encage::replay
