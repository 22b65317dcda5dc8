// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/recording.h"
#include "bench/replay/gate.h"

#include <encage/separated.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace encage::replay {

/// Encage's continuous detection with narrow phase, and its discrete one for the same steps and pairs.
struct Continuous {
  std::int64_t steps = 0;
  std::int64_t left_out = 0;        ///< pairs that touch at the start of their step
  std::int64_t asked = 0;           ///< pairs whose swept boxes overlap, without these
  std::int64_t survivors = 0;       ///< of these, not proven separated
  std::int64_t contacts = 0;        ///< of these, with a first contact
  double ms_per_step = 0;           ///< boxes, separated(), first_contact(); CPU time of the one thread
  double discrete_ms_per_step = 0;  ///< boxes, separated(), at the poses at which the steps start
};

/// `touching`: pairs that touch at the start, per step, sorted; they are left out.
Continuous continuous(
    const Shape& shape, const bench::Recording& recording, const std::vector<std::vector<BodyPair>>& touching, int runs,
    const std::function<void(double fraction)>& progress = [](double) {});

}  // namespace encage::replay
