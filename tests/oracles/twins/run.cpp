// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/twins/run.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <exception>
#include <mutex>
#include <numeric>
#include <thread>

namespace encage::twins {
namespace {

constexpr std::int64_t chunk_size = 128;
constexpr std::size_t most_misses = 20;  // per kind

struct Chunk {
  std::size_t work = 0;
  std::int64_t first = 0, count = 0;
};

/// The works, divided into chunks that are numbered consecutively.
class Chunks {
 public:
  explicit Chunks(const std::vector<Work>& works) : works_(works) {
    for (const Work& work : works) ends_.push_back(count() + (work.count + chunk_size - 1) / chunk_size);
  }

  std::int64_t count() const { return ends_.empty() ? 0 : ends_.back(); }
  Chunk operator[](std::int64_t c) const {
    const auto w = static_cast<std::size_t>(std::upper_bound(ends_.begin(), ends_.end(), c) - ends_.begin());
    const std::int64_t done = (c - (w == 0 ? 0 : ends_[w - 1])) * chunk_size;
    return {w, works_[w].first + done, std::min(chunk_size, works_[w].count - done)};
  }

 private:
  const std::vector<Work>& works_;
  std::vector<std::int64_t> ends_;
};

/// The salt is derived from the kind's name, not from its index among those that run: a pair is the same with and
/// without the others.
std::uint64_t salt_of(const std::string& name) {
  std::uint64_t salt = 0;
  for (const char c : name) salt = test::SplitMix(salt ^ static_cast<unsigned char>(c))();
  return salt;
}

double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class Running {
 public:
  Running(const std::vector<Work>& works, std::uint64_t seed) : works_(works), chunks_(works), seed_(seed) {
    report_.tallies.resize(works.size());
    report_.seconds.resize(works.size());
  }

  void work() {
    try {
      for (std::int64_t c = next_++; c < chunks_.count() && !stop_; c = next_++) {
        ask(chunks_[c]);
        ++done_;
      }
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!error_) error_ = std::current_exception();
      stop_ = true;
    }
    ++ended_;
  }

  void stop() { stop_ = true; }
  int ended() const { return ended_; }
  double fraction() const {
    return static_cast<double>(done_) / static_cast<double>(std::max<std::int64_t>(chunks_.count(), 1));
  }

  Report finish() {
    if (error_) std::rethrow_exception(error_);
    std::vector<Miss> kept;
    for (const Work& work : works_) {
      std::vector<Miss> of_kind;
      std::copy_if(report_.misses.begin(), report_.misses.end(), std::back_inserter(of_kind),
                   [&](const Miss& miss) { return miss.kind == work.name; });
      std::sort(of_kind.begin(), of_kind.end(), [](const Miss& x, const Miss& y) { return x.number < y.number; });
      of_kind.resize(std::min(of_kind.size(), most_misses));
      kept.insert(kept.end(), of_kind.begin(), of_kind.end());
    }
    report_.misses = std::move(kept);
    return std::move(report_);
  }

 private:
  void ask(const Chunk& chunk) {
    const Work& work = works_[chunk.work];
    const std::uint64_t salt = salt_of(work.name);
    Tally tally;
    std::vector<Miss> misses;
    const double start = thread_seconds();
    for (std::int64_t n = chunk.first; n < chunk.first + chunk.count; ++n) {
      const Outcome outcome = ask_pair(*work.kind, salt, seed_, n);
      tally.add(outcome);
      if (outcome.missed) misses.push_back({work.name, n, outcome.what});
    }
    const double seconds = thread_seconds() - start;
    const std::scoped_lock lock(mutex_);
    report_.tallies[chunk.work].add(tally);
    report_.seconds[chunk.work] += seconds;
    report_.misses.insert(report_.misses.end(), misses.begin(), misses.end());
  }

  const std::vector<Work>& works_;
  const Chunks chunks_;
  const std::uint64_t seed_;
  std::atomic<std::int64_t> next_ = 0, done_ = 0;
  std::atomic<int> ended_ = 0;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;  // guards the following members
  Report report_;
  std::exception_ptr error_;
};

}  // namespace

std::vector<std::int64_t> divide(std::int64_t pairs, const std::vector<int>& shares) {
  const std::int64_t all = std::accumulate(shares.begin(), shares.end(), std::int64_t{0});
  std::vector<std::int64_t> counts;
  for (const int share : shares) counts.push_back(pairs / all * share + pairs % all * share / all);
  std::int64_t left = pairs - std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  for (std::size_t i = 0; left > 0; ++i, --left) ++counts[i % counts.size()];
  return counts;
}

Report run(const std::vector<Work>& works, std::uint64_t seed, int threads,
           const std::function<void(double)>& progress) {
  Running running(works, seed);
  std::vector<std::jthread> workers;
  for (int t = 0; t < threads; ++t) workers.emplace_back([&] { running.work(); });
  try {
    while (running.ended() < threads) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      progress(running.fraction());
    }
  } catch (...) {
    running.stop();
    throw;
  }
  workers.clear();
  return running.finish();
}

}  // namespace encage::twins
