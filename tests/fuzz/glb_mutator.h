// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace encage::fuzz {

/// The two chunks of a binary glTF file.
struct Chunks {
  std::string json, bin;
};

/// No value if the bytes are no such file with both chunks.
std::optional<Chunks> split(std::string_view bytes);

/// A file with lengths that are right, and data that begin at a multiple of `alignment`.
std::string join(const Chunks& chunks, std::size_t alignment);

/// Changes one of the chunks.
void mutate(Chunks& chunks, std::size_t max_size, unsigned seed);

}  // namespace encage::fuzz
