// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/step_times.h"

#include <algorithm>

namespace encage::replay {

double StepTimes::mean_of_medians() const {
  double sum = 0;
  for (std::vector<double> times : milliseconds_) {
    if (times.empty()) continue;
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    sum += *middle;
  }
  return milliseconds_.empty() ? 0 : sum / static_cast<double>(milliseconds_.size());
}

}  // namespace encage::replay
