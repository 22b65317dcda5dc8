// SPDX-License-Identifier: Apache-2.0
#pragma once

// Searches on the threads of oneTBB. This header is all there is: link TBB::tbb where you include it.

#include <encage/executor.h>
#include <encage/export.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/partitioner.h>
#include <oneapi/tbb/task_arena.h>

namespace ENCAGE_EXPORT encage {

/// Runs tasks in the arena of the thread that searches; by default as many as that arena has threads.
inline Executor tbb_executor(int threads = oneapi::tbb::this_task_arena::max_concurrency()) {
  return {threads, [](int count, TaskRef task) {
            // A thread that waits for the last tasks must take no other work, which might search the same world.
            oneapi::tbb::this_task_arena::isolate([&] {
              oneapi::tbb::parallel_for(
                  oneapi::tbb::blocked_range<int>(0, count, 1),
                  [&](const oneapi::tbb::blocked_range<int>& range) {
                    for (int i = range.begin(); i != range.end(); ++i) task(i);
                  },
                  oneapi::tbb::simple_partitioner());
            });
          }};
}

/// Runs tasks in an arena, which has to outlive the executor.
inline Executor tbb_executor(oneapi::tbb::task_arena& arena) {
  const Executor inside = tbb_executor(arena.max_concurrency());
  return {inside.threads,
          [&arena, inside](int count, TaskRef task) { arena.execute([&] { inside.run(count, task); }); }};
}

}  // namespace encage
