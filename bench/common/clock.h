// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/process.h"

#include <chrono>

namespace encage::bench {

/// Adds the CPU seconds that the calling thread uses during its lifetime to a sum.
class CpuTimer {
 public:
  explicit CpuTimer(double& sum) : sum_(sum), start_(thread_cpu_seconds()) {}
  ~CpuTimer() { sum_ += thread_cpu_seconds() - start_; }
  CpuTimer(const CpuTimer&) = delete;
  CpuTimer& operator=(const CpuTimer&) = delete;

 private:
  double& sum_;
  double start_;
};

/// CPU milliseconds that the calling thread spends in task().
template <class Task>
double cpu_milliseconds(const Task& task) {
  const double start = thread_cpu_seconds();
  task();
  return 1e3 * (thread_cpu_seconds() - start);
}

/// Wall-clock time since it was made.
class Stopwatch {
 public:
  double milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace encage::bench
