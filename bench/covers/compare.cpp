// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/compare.h"

#include "bench/replay/step_times.h"

namespace encage::covers {
namespace {

std::vector<bool> verdicts(const Contestant& contestant, const PairLists& lists) {
  std::vector<bool> apart;
  for (const auto& list : lists) {
    for (const PairCase& pair : list) apart.push_back(contestant.apart(pair));
  }
  return apart;
}

std::int64_t count_apart(const Contestant& contestant, const std::vector<PairCase>& list) {
  std::int64_t count = 0;
  for (const PairCase& pair : list) count += contestant.apart(pair) ? 1 : 0;
  return count;
}

}  // namespace

std::int64_t Comparison::doubtful() const {
  std::int64_t sum = 0;
  for (const Score& score : scores) sum += score.rejected - score.rejected_by_fine;
  return sum;
}

Comparison compare(const Contestants& contestants, const PairLists& lists, int runs,
                   const std::function<void(double fraction)>& progress) {
  Comparison result;
  result.steps = static_cast<std::int64_t>(lists.size());
  for (const auto& list : lists) result.pairs += static_cast<std::int64_t>(list.size());

  const std::vector<bool> fine = verdicts(*contestants.front(), lists);
  for (const auto& contestant : contestants) {
    Score& score = result.scores.emplace_back();
    score.name = contestant->name();
    score.bytes = contestant->bytes();
    const std::vector<bool> apart = verdicts(*contestant, lists);
    for (std::size_t i = 0; i < fine.size(); ++i) {
      score.rejected += apart[i] ? 1 : 0;
      score.rejected_by_fine += apart[i] && fine[i] ? 1 : 0;
    }
    progress(0);
  }

  std::vector<replay::StepTimes> times(contestants.size(), replay::StepTimes(lists.size()));
  std::size_t done = 0;
  replay::in_turns(runs, lists.size(), [&](std::size_t first, std::size_t last) {
    for (std::size_t c = 0; c < contestants.size(); ++c) {
      for (std::size_t s = first; s < last; ++s) {
        times[c].time(s, [&] { return count_apart(*contestants[c], lists[s]); });
      }
    }
    done += last - first;
    progress(static_cast<double>(done) / (static_cast<double>(lists.size()) * runs));
  });
  for (std::size_t c = 0; c < contestants.size(); ++c) result.scores[c].us_per_step = 1e3 * times[c].mean_of_medians();
  return result;
}

}  // namespace encage::covers
