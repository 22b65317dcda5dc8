// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/covers/contestants.h"

#include <functional>

namespace encage::covers {

/// What a contestant did.
struct Score {
  std::string name;
  std::size_t bytes = 0;
  std::int64_t rejected = 0;          ///< pairs proven apart
  std::int64_t rejected_by_fine = 0;  ///< of them, those that the fine mesh proves apart as well
  double us_per_step = 0;             ///< CPU time of the one thread
};

struct Comparison {
  std::int64_t steps = 0, pairs = 0;
  std::vector<Score> scores;  ///< that of the fine mesh first

  /// Pairs that somebody rejects and the fine mesh does not. Of bodies at rest that must be none.
  std::int64_t doubtful() const;
};

/// Asks all contestants, the fine mesh first, for all pairs. In every run they take turns (step_times.h).
Comparison compare(
    const Contestants& contestants, const PairLists& lists, int runs,
    const std::function<void(double fraction)>& progress = [](double) {});

}  // namespace encage::covers
