// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/threads/parallel.h"

#include "cagegen/threads/run_reporting.h"

#include <encage/error.h>

#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace encage::makers {
namespace {

/// The stack that new threads get, so large that the system has to refuse them; that of before at the end.
class NoThreads {
 public:
  explicit NoThreads(bool now = true) {
    pthread_getattr_default_np(&before_);
    if (now) refuse();
  }
  ~NoThreads() {
    pthread_setattr_default_np(&before_);
    pthread_attr_destroy(&before_);
  }
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;

  void refuse() {
    pthread_attr_t huge;
    pthread_attr_init(&huge);
    EXPECT_EQ(pthread_attr_setstacksize(&huge, std::size_t{1} << 50), 0);
    EXPECT_EQ(pthread_setattr_default_np(&huge), 0);
    pthread_attr_destroy(&huge);
  }

 private:
  pthread_attr_t before_;
};

std::vector<int> calls(int threads, std::size_t count) {
  std::vector<int> called(count, 0);
  for_each_task(threads, count, [&](std::size_t i) { ++called[i]; });
  return called;
}

TEST(Parallel, every_task_runs_once) {
  for (const int threads : {-1, 0, 1, 2, 7, 1024}) {
    for (const std::size_t count : {0, 1, 5, 1000}) EXPECT_EQ(calls(threads, count), std::vector<int>(count, 1));
  }
}

TEST(Parallel, ranges_make_up_the_whole) {
  for (const int threads : {1, 3, 1024}) {
    for (const std::size_t count : {0, 9, 10, 1001}) {
      std::vector<int> called(count, 0);
      std::atomic<std::size_t> shortest{count};
      for_ranges(threads, count, 5, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) ++called[i];
        if (last - first < shortest) shortest = last - first;
      });
      EXPECT_EQ(called, std::vector<int>(count, 1));
      EXPECT_GE(shortest, std::min<std::size_t>(count, 5));
    }
  }
}

TEST(Parallel, throws_what_the_first_of_the_tasks_threw) {
  for (const int threads : {1, 4}) {
    std::atomic<int> done{0};
    const auto task = [&](std::size_t i) {
      if (i == 3 || i == 40) throw std::runtime_error(std::to_string(i));
      ++done;
    };
    try {
      for_each_task(threads, 50, task);
      ADD_FAILURE();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "3");
    }
    EXPECT_EQ(done, 48);
  }
}

TEST(Parallel, works_alone_where_the_system_starts_no_thread) {
  const NoThreads refused;
  ASSERT_ANY_THROW(std::thread([] {}).join()) << "the system starts threads after all";
  EXPECT_EQ(calls(1024, 2000), std::vector<int>(2000, 1));
}

TEST(Parallel, works_with_those_threads_that_the_system_has_started) {
  NoThreads refused(false);
  std::mutex mutex;
  std::set<std::thread::id> seen;
  std::vector<int> called(2000, 0);
  for_each_task(1024, called.size(), [&](std::size_t i) {
    const std::lock_guard lock(mutex);
    // The first thread that runs takes care that soon there is no other.
    if (seen.empty()) refused.refuse();
    seen.insert(std::this_thread::get_id());
    ++called[i];
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  });
  EXPECT_EQ(called, std::vector<int>(2000, 1));
  EXPECT_LT(seen.size(), 1024u);
}

TEST(RunReporting, says_so_where_the_system_starts_no_thread) {
  const NoThreads refused;
  const auto nothing = [] {};
  try {
    run_reporting(nothing, nothing, nothing);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).rfind("bake: the system starts no thread: ", 0), 0u) << error.what();
  }
}

}  // namespace
}  // namespace encage::makers
