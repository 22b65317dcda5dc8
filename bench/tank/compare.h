// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/strategy.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace encage::tank {

/// When the features of a contact that was reported really touch; no value: never in this step.
using Judge = std::function<std::optional<double>(const bench::RecordedStep& step, const BodyContact& contact)>;

/// A reported time may lie this much before that of the features reported with it: what PairContact allows among
/// contacts at one time, a span of its bisection, and rounding.
inline constexpr double time_tolerance = 0x1p-20 + 0x1p-21;

/// What is wrong with one strategy's answers.
struct Faults {
  std::int64_t missed = 0;    ///< pairs that touch, of which it reports nothing or too late a time
  std::int64_t spurious = 0;  ///< pairs of which it reports a contact that does not happen, or too early a time

  Faults& operator+=(const Faults& other);
  friend bool operator==(const Faults&, const Faults&) = default;
};

/// Compares what several strategies answered about the same step. The judge is asked about every contact that one of
/// them reports; the earliest real one of a pair is what the others are held against.
std::vector<Faults> compare(const bench::RecordedStep& step, const std::vector<const Detection*>& answers,
                            const Judge& judge);

}  // namespace encage::tank
