// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/fuzz.h"

#include <sanitizer/allocator_interface.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace encage::fuzz {
namespace {

// Bytes. Readers run in one thread.
std::int64_t most_allowed = 0;  ///< 0: do not count
std::int64_t live = 0;
std::int64_t peak = 0;  ///< of all inputs

void count_allocation(const volatile void*, std::size_t size) {
  if (most_allowed == 0) return;
  live += static_cast<std::int64_t>(size);
  peak = std::max(peak, live);
  if (live <= most_allowed) return;
  most_allowed = 0;
  report("more memory than a file of this size may take");
}

void count_release(const volatile void* block) {
  if (most_allowed == 0 || block == nullptr) return;
  live -= static_cast<std::int64_t>(__sanitizer_get_allocated_size(block));
}

}  // namespace

void report(const char* what) {
  std::fprintf(stderr, "FIND: %s\n", what);
  std::abort();
}

MemoryBound::MemoryBound(std::int64_t most) {
  live = 0;
  most_allowed = most;
}

MemoryBound::~MemoryBound() { most_allowed = 0; }

}  // namespace encage::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  __sanitizer_install_malloc_and_free_hooks(encage::fuzz::count_allocation, encage::fuzz::count_release);
  std::atexit(
      [] { std::fprintf(stderr, "peak of one input: %lld bytes\n", static_cast<long long>(encage::fuzz::peak)); });
  return 0;
}
