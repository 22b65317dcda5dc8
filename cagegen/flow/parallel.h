// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace encage::makers {

/// Calls work(first, last) for ranges that make up [0, count), on up to `threads` threads, and returns when all
/// are done. Items must not depend on each other. The first exception, in the order of the ranges, is thrown on.
template <class Work>
void for_ranges(int threads, std::size_t count, const Work& work) {
  constexpr std::size_t least = 512;  // items worth a thread
  const std::size_t parts = std::clamp<std::size_t>(count / least, 1, static_cast<std::size_t>(std::max(1, threads)));
  if (parts == 1) return work(std::size_t{0}, count);
  std::vector<std::exception_ptr> errors(parts);
  const auto run = [&](std::size_t part) {
    try {
      work(count * part / parts, count * (part + 1) / parts);
    } catch (...) {
      errors[part] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> workers;
    for (std::size_t part = 1; part < parts; ++part) workers.emplace_back(run, part);
    run(0);
  }
  for (const std::exception_ptr& error : errors) {
    if (error) std::rethrow_exception(error);
  }
}

}  // namespace encage::makers
