// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/twins/pair_kind.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace encage::twins {

/// Pairs `first` to `first + count` of a kind.
struct Work {
  std::string name;
  const PairKind* kind = nullptr;
  std::int64_t first = 0, count = 0;
};

struct Miss {
  std::string kind;
  std::int64_t number = 0;
  std::string what;
};

struct Report {
  std::vector<Tally> tallies;   ///< one per work
  std::vector<double> seconds;  ///< CPU time, summed over the threads
  std::vector<Miss> misses;     ///< sorted by work, then number; if there are many, only the first ones of each work
};

/// Divides `pairs` by the shares of the kinds; the first kinds get the remainder.
std::vector<std::int64_t> divide(std::int64_t pairs, const std::vector<int>& shares);

/// Tests all pairs. Except for `seconds` the report depends on works and seed alone, not on the threads. `progress`
/// gets the completed fraction, on the calling thread. If it or a kind throws, the run ends.
Report run(
    const std::vector<Work>& works, std::uint64_t seed, int threads,
    const std::function<void(double)>& progress = [](double) {});

}  // namespace encage::twins
