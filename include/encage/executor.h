// SPDX-License-Identifier: Apache-2.0
#pragma once

// A search borrows the caller's threads through these types.

#include <encage/export.h>

#include <concepts>
#include <functional>
#include <type_traits>

namespace ENCAGE_EXPORT encage {

/// Refers to the work of one Executor::run(). It is two words long: copy it, but do not keep it after run() has
/// returned.
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
  /// The number of tasks that run well at the same time, including that of the calling thread: >= 1, usually the number
  /// of threads. With 1, `run` is not called.
  int threads = 1;
  /// run(count, task), 2 <= count <= threads, calls task(i) once for every i in [0, count). It returns when all calls
  /// have returned, and makes their effects visible. It may throw, once the calls that it began have returned: the
  /// search then ends and leaves the world in order. The searching thread calls it, at most once at a time; while that
  /// thread waits, it must not be given work that uses the same world.
  std::function<void(int count, TaskRef task)> run{};
};

}  // namespace encage
