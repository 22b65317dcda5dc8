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
  std::vector<Tally> tallies;   ///< one for each work
  std::vector<double> seconds;  ///< of CPU time, summed over the threads
  std::vector<Miss> misses;     ///< by work, then number; the first ones of each work if there are many
};

/// `pairs` divided by the shares of the kinds; the first kinds get what is left over.
std::vector<std::int64_t> divide(std::int64_t pairs, const std::vector<int>& shares);

/// Asks about all pairs. But for `seconds` the report depends on works and seed alone, not on the threads.
/// `progress` gets the fraction done, on the calling thread; what it or a kind throws ends the run.
Report run(
    const std::vector<Work>& works, std::uint64_t seed, int threads,
    const std::function<void(double)>& progress = [](double) {});

}  // namespace encage::twins
