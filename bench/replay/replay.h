// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/replay/engine.h"

namespace encage::replay {

struct EngineResult {
  std::string name;
  double ms_per_step = 0;               ///< CPU time of the one thread
  std::optional<double> with_cages_ms;  ///< behind the gate
  std::int64_t touching = 0;            ///< pairs, summed over the steps
};

/// A pair on which the answers of a step differ.
struct Disagreement {
  std::int64_t step = 0;
  BodyPair pair;
  std::vector<std::string> touching;  ///< who says that it touches, e.g. "fcl", "fcl+cages"
};

struct Replay {
  std::int64_t steps = 0;
  std::vector<EngineResult> engines;
  std::vector<Disagreement> disagreements;
};

/// Asks all engines about the same steps, each alone and, if there is a gate, behind it. In every one of
/// `runs` runs, they take turns step by step; a step counts with its median time.
Replay replay(
    const std::vector<std::unique_ptr<Engine>>& engines, const CageGate* gate, const std::vector<PoseStep>& steps,
    int runs, const std::function<void(double fraction)>& progress = [](double) {});

}  // namespace encage::replay
