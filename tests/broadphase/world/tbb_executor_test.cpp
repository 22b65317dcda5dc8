// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/world/twin.h"

#include <encage/tbb_executor.h>

#include <oneapi/tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

namespace encage::test {
namespace {

namespace tbb = oneapi::tbb;

// Provides the requested number of threads on any machine.
const tbb::global_control enough_threads(tbb::global_control::max_allowed_parallelism, 4);

TEST(TbbExecutor, RunsEachTaskOnce) {
  tbb::task_arena arena(3);
  EXPECT_EQ(tbb_executor(arena).threads, 3);
  EXPECT_GE(tbb_executor().threads, 1);
  for (const Executor& executor : {tbb_executor(4), tbb_executor(arena)}) {
    std::vector<std::atomic<int>> calls(100);
    const auto work = [&](int i) { ++calls[i]; };
    executor.run(100, TaskRef(work));
    for (const auto& count : calls) EXPECT_EQ(count, 1);
  }
}

/// Returns the candidates of a few steps.
std::vector<std::vector<Found>> walk(unsigned seed, const Executor& executor) {
  Twin twin(seed);
  std::vector<std::vector<Found>> steps;
  for (int i = 0; i < 40; ++i) twin.add_body();
  for (unsigned step = 0; step < 5; ++step) {
    for (unsigned i = 0; i < 12; ++i) twin.change(1 + (i + step) % 9);
    steps.push_back(candidates(twin.world, {.executor = executor}));
  }
  return steps;
}

TEST(TbbExecutor, GivesWhatTheCallingThreadGives) {
  const auto expected = walk(3, {});
  tbb::task_arena arena(2);
  EXPECT_EQ(walk(3, tbb_executor(2)), expected);
  EXPECT_EQ(walk(3, tbb_executor(arena)), expected);
}

TEST(TbbExecutor, MayBeUsedFromTasksOfTheSameThreads) {
  std::vector<std::vector<std::vector<Found>>> got(8);
  tbb::parallel_for(0, 8, [&](int i) { got[i] = walk(static_cast<unsigned>(i), tbb_executor(3)); });
  for (unsigned i = 0; i < 8; ++i) EXPECT_EQ(got[i], walk(i, {}));
}

TEST(TbbExecutor, AWaitingThreadTakesNoOtherWork) {
  tbb::task_arena arena(2);
  const Executor executor = tbb_executor(arena);
  std::atomic<bool> second_began = false, taken_early = false, other_ran = false;
  const std::thread::id caller = std::this_thread::get_id();
  const auto wait_for = [](const std::atomic<bool>& flag, int milliseconds) {
    for (int i = 0; i < milliseconds && !flag; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  // The first task makes a thread wait for the second while the arena has other work.
  const auto work = [&](int i) {
    if (i == 0) {
      wait_for(second_began, 2000);
    } else {
      second_began = true;
      arena.enqueue([&] {
        taken_early = std::this_thread::get_id() == caller;
        other_ran = true;
      });
      wait_for(taken_early, 30);
    }
  };
  executor.run(2, TaskRef(work));
  wait_for(other_ran, 10000);
  ASSERT_TRUE(second_began && other_ran);
  EXPECT_FALSE(taken_early);
}

}  // namespace
}  // namespace encage::test
