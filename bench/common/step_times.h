// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/clock.h"

#include <cstddef>
#include <vector>

namespace encage::bench {

/// CPU time of the calling thread for each step, over several runs.
class StepTimes {
 public:
  explicit StepTimes(std::size_t steps) : milliseconds_(steps) {}

  /// Times task() and returns what it returns.
  template <class Task>
  auto time(std::size_t step, const Task& task) {
    const double start = thread_cpu_seconds();
    auto result = task();
    add(step, 1e3 * (thread_cpu_seconds() - start));
    return result;
  }

  void add(std::size_t step, double milliseconds) { milliseconds_[step].push_back(milliseconds); }

  /// Each step counts with the median of its runs.
  double mean_of_medians() const;
  double worst_median() const;  ///< of the slowest step

 private:
  std::vector<std::vector<double>> milliseconds_;
};

/// Calls visit(first, last) so that contestants who take turns replay some steps in a row, with warm caches as in an
/// application, and yet share what becomes of the machine over time.
template <class Visit>
void in_turns(int runs, std::size_t steps, const Visit& visit) {
  constexpr std::size_t in_a_row = 20;
  for (int run = 0; run < runs; ++run) {
    for (std::size_t first = 0; first < steps; first += in_a_row) {
      visit(first, first + in_a_row < steps ? first + in_a_row : steps);
    }
  }
}

}  // namespace encage::bench
