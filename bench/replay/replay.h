// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace encage::replay {

/// A test of ours in front of engines.
struct Front {
  std::string name;  ///< "cages", "full"
  const Gate* gate = nullptr;
};

struct PairQuestion {
  std::vector<PoseStep> steps;
  std::vector<std::vector<BodyPair>> truth;     ///< the pairs that touch, per step, sorted; none that is left out
  std::vector<std::vector<BodyPair>> left_out;  ///< the pairs that nobody is asked for, likewise; or empty
  std::vector<Front> fronts;
  int runs = 3;
};

/// An engine, alone or behind a test.
struct Answer {
  std::string front;          ///< empty: the engine alone
  double ms_per_step = 0;     ///< CPU time of the one thread
  std::int64_t touching = 0;  ///< pairs, summed over the steps
  std::int64_t missed = 0;    ///< pairs that touch, but not by this answer
  std::int64_t spurious = 0;  ///< pairs that touch by this answer only
};

struct EngineResult {
  std::string name;
  Answer alone;
  std::vector<Answer> behind;  ///< each front
  double perfect_ms = 0;       ///< behind a test that knows which pairs touch, and takes no time: the bound
};

/// A pair about which somebody is wrong.
struct Disagreement {
  std::int64_t step = 0;
  BodyPair pair;
  bool truth = false;
  std::vector<std::string> touching;  ///< who says that it touches, e.g. "fcl", "fcl+cages"
};

struct Replay {
  std::int64_t steps = 0;
  std::int64_t touching = 0;  ///< pairs, truly, summed over the steps
  std::int64_t left_out = 0;  ///< pairs that nobody was asked for
  std::vector<EngineResult> engines;
  std::vector<Disagreement> disagreements;
};

/// Asks all engines about the same steps, each alone, behind every front that makes sense for it (FineGate is what
/// Encage does itself), and behind PerfectGate. In every run they take turns (step_times.h).
Replay replay(
    const std::vector<std::unique_ptr<Engine>>& engines, const PairQuestion& question,
    const std::function<void(double fraction)>& progress = [](double) {});

}  // namespace encage::replay
