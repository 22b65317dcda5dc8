// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/recording.h"
#include "bench/tank/compare.h"
#include "bench/tank/strategy.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace encage::tank {

struct MeasureOptions {
  StrategyOptions strategy;
  /// Steps on which the rebuild strategies are timed, evenly spread: one of them takes about a second, with half a
  /// million triangles and eighteen bodies. 0: they are not run.
  std::int64_t rebuild_steps = 40;
  int runs = 3;  ///< of the prebuilt strategies over all steps; each step counts with its median time
  /// By default every contact is taken to happen when it was reported: a strategy that lacks it has missed it.
  Judge judge = [](const bench::RecordedStep&, const BodyContact& c) { return std::optional(c.contact.time); };
  /// Called a few times a second from the calling thread.
  std::function<void(double fraction, std::string_view what)> progress = [](double, std::string_view) {};
};

/// What one strategy took and answered. Times are CPU time of the one thread.
struct StrategyResult {
  std::string name;
  std::int64_t steps_timed = 0;
  double ms_per_step = 0;   ///< mean over the steps timed
  double sampled_ms = 0;    ///< mean over the steps on which all strategies were timed
  StageCounts counts;       ///< sums over the steps timed
  std::int64_t bodies = 0;  ///< over all steps: bodies in pairs that survive, whose trees a rebuild strategy builds
  bool rebuilds = false;
  Faults faults;
};

struct Measurement {
  std::int64_t steps = 0;
  std::int64_t sampled_steps = 0;
  /// Pairs times steps: not proven apart where the step begins, hence not asked in that step.
  std::int64_t left_out = 0;
  StageCounts counts;              ///< sums over all steps, cages asked
  std::int64_t oracle_bodies = 0;  ///< over all steps: bodies that touch another one in the step
  std::vector<StrategyResult> strategies;

  /// Throws std::out_of_range.
  const StrategyResult& strategy(const std::string& name) const;
  /// Ratio of the times of two strategies on the sampled steps; 0 if one was not timed.
  double speedup(const std::string& slow, const std::string& fast) const;
  /// Bodies rebuilt over all steps, without / with cages.
  double speedup_count() const;
  Faults faults() const;
};

/// Asks all strategies about the recorded steps. One thread.
Measurement measure(const TankBody& body, const bench::Recording& recording, const MeasureOptions& options);

/// Pairs of the step whose fine meshes are not proven apart where the step begins.
std::vector<IndexPair> pairs_in_contact_at_start(const TankBody& body, const bench::RecordedStep& step);

}  // namespace encage::tank
