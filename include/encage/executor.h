// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a search borrows the caller's threads.

#include <encage/export.h>

#include <concepts>
#include <functional>
#include <type_traits>

namespace ENCAGE_EXPORT encage {

/// Refers to what the tasks of one Executor::run() do. It is two words long: copy it, but do not keep it after run().
class TaskRef {
 public:
  template <class Function>
  requires(!std::same_as<std::remove_cv_t<Function>, TaskRef>) explicit TaskRef(Function& function) noexcept
      : context_(const_cast<void*>(static_cast<const void*>(&function))),
        call_([](void* context, int i) noexcept { (*static_cast<Function*>(context))(i); }) {}

  /// Does task i. It never throws, never blocks, and calls none of the caller's functions.
  void operator()(int i) const noexcept { call_(context_, i); }

 private:
  void* context_;
  void (*call_)(void* context, int i) noexcept;
};

/// The caller's job system. <encage/tbb_executor.h> has one for oneTBB; the default is the calling thread alone.
///
/// Tasks share the work among themselves while they run and never wait for each other. They need not run at the same
/// time, nor in order, nor on other threads than the calling one: threads that are busy elsewhere make a search slower,
/// not wrong. For example:
///
///   options.executor = {jobs.threads(), [&](int count, TaskRef task) { jobs.parallel_for(count, task); }};
struct Executor {
  /// How many tasks are worth running at once, the calling thread's included: >= 1. With 1, `run` is not called.
  int threads = 1;
  /// run(count, task), 2 <= count <= threads, calls task(i) once for every i in [0, count). It returns when all calls
  /// have returned, and makes their effects visible. It may throw, once the calls that it began have returned: that
  /// ends the search and leaves the world in order. The thread that searches calls it, at most once at a time; while
  /// that thread waits, it must not be given work that uses the same world.
  std::function<void(int count, TaskRef task)> run{};
};

}  // namespace encage
