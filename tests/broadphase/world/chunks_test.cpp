// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/world/chunks.h"

#include "tests/broadphase/world/thread_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace encage::test {
namespace {

TEST(Chunks, EachIsVisitedOnceWhateverTheSizes) {
  for (const int threads : {1, 2, 3, 7}) {
    ThreadPool pool(threads);
    for (const std::size_t size : {0, 1, 2, 3, 25, 64, 1000, 20001}) {
      std::vector<std::atomic<int>> visits(size + 5);
      const std::size_t end = for_each_in_chunks(pool.executor(), 5, 5 + size, [&](std::size_t i) {
        ++visits[i];
        return true;
      });
      EXPECT_EQ(end, 5 + size);
      for (std::size_t i = 0; i < visits.size(); ++i) ASSERT_EQ(visits[i], i < 5 ? 0 : 1) << i;
    }
  }
}

TEST(Chunks, AFewPairsAreSharedOneByOne) {
  int count = 0;
  std::vector<std::size_t> first;
  const Executor executor{4, [&](int tasks, TaskRef task) {
                            count = tasks;
                            task(3);
                            task(0);
                          }};
  for_each_in_chunks(executor, 0, 3, [&](std::size_t i) {
    first.push_back(i);
    return true;
  });
  EXPECT_EQ(count, 3);
  EXPECT_EQ(first, (std::vector<std::size_t>{0, 1, 2}));
}

TEST(Chunks, AStopEndsWithTheChunksThatAreBegun) {
  ThreadPool pool(3);
  for (const std::size_t size : {10, 10000}) {
    std::vector<std::atomic<int>> visits(size);
    const std::size_t end = for_each_in_chunks(pool.executor(), 0, size, [&](std::size_t i) {
      ++visits[i];
      return i != 4;
    });
    EXPECT_GT(end, 4u);
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(visits[i], i < end ? 1 : 0) << i;
  }
  const Executor alone{2, [](int, TaskRef task) { task(0); }};
  EXPECT_EQ(for_each_in_chunks(alone, 0, 100, [](std::size_t i) { return i != 4; }), 5u);
}

TEST(Chunks, NothingIsVisitedByAnExecutorThatRunsNothing) {
  const Executor idle{2, [](int, TaskRef) {}}, broken{2, [](int, TaskRef) { throw std::runtime_error("broken"); }};
  const auto no_visit = [](std::size_t) -> bool { std::abort(); };
  EXPECT_EQ(for_each_in_chunks(idle, 3, 9, no_visit), 3u);
  EXPECT_THROW(for_each_in_chunks(broken, 3, 9, no_visit), std::runtime_error);
}

}  // namespace
}  // namespace encage::test
