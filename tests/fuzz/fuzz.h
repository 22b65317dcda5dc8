// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/error.h>

#include <cstddef>
#include <cstdint>
#include <string_view>

// What the targets share. A target hands bytes to a reader, which has to read them or to throw Error. Everything else
// is a find: another exception, what the sanitizers see, a result that breaks its promises, too much memory.

namespace encage::fuzz {

/// Ends the program, as a find.
[[noreturn]] void report(const char* what);

inline void require(bool holds, const char* what) {
  if (!holds) report(what);
}

/// As long as it lives, more than `most` bytes of memory at a time are a find.
class MemoryBound {
 public:
  explicit MemoryBound(std::int64_t most);
  ~MemoryBound();
  MemoryBound(const MemoryBound&) = delete;
  MemoryBound& operator=(const MemoryBound&) = delete;
};

/// What reading a file may take: bytes for each byte of the file, beside 64 MiB.
constexpr std::int64_t memory_for(std::size_t file_size, std::int64_t per_byte = 10) {
  return (std::int64_t{64} << 20) + per_byte * static_cast<std::int64_t>(file_size);
}

/// Returns whether the bytes were read; Error is the other answer. `out_of_memory` is what a reader makes of
/// std::bad_alloc.
template <class Read>
bool reads(std::int64_t most_memory, const Read& read, std::string_view out_of_memory = {}) {
  const MemoryBound bound(most_memory);
  try {
    read();
    return true;
  } catch (const Error& error) {
    require(error.what() != out_of_memory, "out of memory");
    return false;
  }
}

}  // namespace encage::fuzz
