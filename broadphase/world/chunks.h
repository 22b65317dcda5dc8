// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/executor.h>

#include <algorithm>
#include <atomic>
#include <cstddef>

namespace encage {

/// Calls visit(i) once for every i in [first, last), in tasks that take chunks in increasing order, until a call
/// returns false: tasks then finish the chunks they have begun and take no more. Returns the end of the visited range.
/// Costs of calls may differ much, so chunks are small. Several threads call visit, which must not throw; exceptions of
/// the executor pass through.
template <class Visit>
std::size_t for_each_in_chunks(const Executor& executor, std::size_t first, std::size_t last, Visit&& visit) {
  constexpr std::size_t largest_chunk = 64, chunks_per_task = 32;
  const std::size_t size = last - first, threads = static_cast<std::size_t>(executor.threads);
  const std::size_t chunk = std::clamp<std::size_t>(size / (threads * chunks_per_task), 1, largest_chunk);
  alignas(64) std::atomic<std::size_t> next{first};
  std::atomic<bool> stopped{false};
  const auto work = [&](int) noexcept {
    while (!stopped.load(std::memory_order_relaxed)) {
      const std::size_t begin = next.fetch_add(chunk, std::memory_order_relaxed);
      if (begin >= last) return;
      const std::size_t end = std::min(begin + chunk, last);
      for (std::size_t i = begin; i < end; ++i) {
        if (!visit(i)) stopped.store(true, std::memory_order_relaxed);
      }
    }
  };
  const std::size_t tasks = std::min(threads, (size + chunk - 1) / chunk);
  if (tasks > 1) {
    executor.run(static_cast<int>(tasks), TaskRef(work));
  } else {
    work(0);
  }
  return std::min(next.load(std::memory_order_relaxed), last);
}

}  // namespace encage
