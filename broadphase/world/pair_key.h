// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace encage {

// A pair of a world as a number: the lower index of a body, then the other body's index, or the half-space's with a bit
// set. The keys thus sort in the order in which candidates are visited.

inline constexpr std::uint32_t half_space_bit = 0x80000000;

/// Returns the key of two bodies, or of a body and half_space_bit | half-space.
inline std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) noexcept {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}
inline std::uint32_t first_of(std::uint64_t key) noexcept { return static_cast<std::uint32_t>(key >> 32); }
inline std::uint32_t second_of(std::uint64_t key) noexcept { return static_cast<std::uint32_t>(key); }
inline bool has_half_space(std::uint64_t key) noexcept { return (key & half_space_bit) != 0; }
inline std::uint32_t half_space_of(std::uint64_t key) noexcept { return second_of(key) & ~half_space_bit; }

}  // namespace encage
