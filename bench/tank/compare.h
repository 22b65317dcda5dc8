// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "bench/tank/strategy.h"

namespace encage::tank {

/// Decides whether a contact that was reported for two bodies of a step happens.
using Judge = std::function<bool(const RecordedStep& step, const BodyContact& contact)>;

/// What is wrong with one strategy's answers.
struct Faults {
  std::int64_t missed = 0;    ///< pairs that touch, but it reports nothing, or a later time than that of a contact
  std::int64_t spurious = 0;  ///< pairs for which it reports a contact that does not happen

  Faults& operator+=(const Faults& other);
};

/// Compares what several strategies answered about the same step. Where they agree, they are
/// believed; the judge is asked about every contact of a pair on which they differ.
std::vector<Faults> compare(const RecordedStep& step, const std::vector<const Detection*>& answers, const Judge& judge);

}  // namespace encage::tank
