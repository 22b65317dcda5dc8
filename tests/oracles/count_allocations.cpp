// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"

#include <cstdlib>
#include <new>

std::atomic<long> allocations{0};
std::atomic<long> allocations_left{-1};

namespace {

void* allocate(std::size_t size) {
  if (allocations_left == 0) return nullptr;
  if (allocations_left > 0) --allocations_left;
  ++allocations;
  return std::malloc(size);
}

}  // namespace

// Not inlined: the compiler would see a mismatch of new and free.
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (void* p = allocate(size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return allocate(size); }
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
