// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/step_times.h"

#include <gtest/gtest.h>

#include <vector>

namespace encage::bench {
namespace {

TEST(StepTimes, ReturnsWhatTheTaskReturns) {
  StepTimes times(2);
  EXPECT_EQ(times.time(1, [] { return 5; }), 5);
}

TEST(StepTimes, StepsCountWithTheirMedian) {
  StepTimes times(2);
  for (const double ms : {1, 100, 2}) times.add(0, ms);
  for (const double ms : {9, 4, 0}) times.add(1, ms);
  EXPECT_EQ(times.mean_of_medians(), 3);
  EXPECT_EQ(StepTimes(0).mean_of_medians(), 0);
}

TEST(InTurns, VisitsEveryStepOnceARun) {
  for (const std::size_t steps : {0, 1, 20, 21, 105}) {
    std::vector<std::size_t> visited, expected;
    in_turns(2, steps, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) visited.push_back(i);
    });
    for (int run = 0; run < 2; ++run) {
      for (std::size_t i = 0; i < steps; ++i) expected.push_back(i);
    }
    EXPECT_EQ(visited, expected);
  }
}

}  // namespace
}  // namespace encage::bench
