// SPDX-License-Identifier: Apache-2.0
#pragma once

// How a search borrows threads of the caller's.

#include <encage/export.h>

#include <concepts>
#include <functional>
#include <type_traits>

namespace ENCAGE_EXPORT encage {

/// Reference to what the tasks of one Executor::run do: two words, to be copied, not to be kept after run().
class TaskRef {
 public:
  template <class Function>
  requires(!std::same_as<std::remove_cv_t<Function>, TaskRef>) explicit TaskRef(Function& function) noexcept
      : context_(const_cast<void*>(static_cast<const void*>(&function))),
        call_([](void* context, int i) noexcept { (*static_cast<Function*>(context))(i); }) {}

  /// Does task i. Never throws, never blocks, calls nothing of the caller's.
  void operator()(int i) const noexcept { call_(context_, i); }

 private:
  void* context_;
  void (*call_)(void* context, int i) noexcept;
};

/// The caller's job system; <encage/tbb_executor.h> has one of oneTBB. The empty one is the calling thread alone.
///
/// Tasks share the work among themselves while they run. They need not run at the same time, nor in order, nor on
/// other threads than the calling one, and never wait for each other: few threads that are
/// busy elsewhere make a search slower, not wrong. E.g.
///
///   options.executor = {jobs.threads(), [&](int count, TaskRef task) { jobs.parallel_for(count, task); }};
struct Executor {
  /// Tasks that are worth running at once, the calling thread's included; >= 1. With 1, `run` is not called.
  int threads = 1;
  /// run(count, task), 2 <= count <= threads: calls task(i) once for every i in [0, count) and returns when all
  /// calls have returned, with their effects visible. May throw only after the calls it has begun have
  /// returned; that ends the search and leaves the world in order. Called by the thread that searches, at most
  /// once at a time; while it waits, that thread must not be given work that uses the same world.
  std::function<void(int count, TaskRef task)> run{};
};

}  // namespace encage
