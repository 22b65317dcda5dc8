// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/step_times.h"

#include "bench/common/statistics.h"

#include <algorithm>

namespace encage::bench {

double StepTimes::mean_of_medians() const { return bench::mean_of_medians(milliseconds_); }

double StepTimes::worst_median() const {
  double worst = 0;
  for (const std::vector<double>& runs : milliseconds_) worst = std::max(worst, median(runs));
  return worst;
}

}  // namespace encage::bench
