// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace encage::makers {

/// Calls task(0), ..., task(count - 1), each once and begun in this order, on up to `threads` threads, the caller's
/// among them; returns when all are done. Tasks must not depend on each other. Where the system refuses to start a
/// thread, those there are do the work. Throws what the first task, in their order, has thrown.
void for_each_task(int threads, std::size_t count, const std::function<void(std::size_t)>& task);

/// Calls work(first, last) for ranges that make up [0, count), with at least `least` items for each thread.
template <class Work>
void for_ranges(int threads, std::size_t count, std::size_t least, const Work& work) {
  const std::size_t parts = std::clamp<std::size_t>(count / least, 1, static_cast<std::size_t>(std::max(1, threads)));
  if (parts == 1) return work(std::size_t{0}, count);
  for_each_task(threads, parts, [&](std::size_t part) { work(count * part / parts, count * (part + 1) / parts); });
}

}  // namespace encage::makers
