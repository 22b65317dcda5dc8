// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace encage::fuzz {

/// The two chunks of a binary glTF file.
struct Chunks {
  std::string json, bin;
};

/// A file with lengths that are right, and data that begin at a multiple of `alignment`.
std::string join(const Chunks& chunks, std::size_t alignment);

/// What libFuzzer takes for its own mutation, which changes one chunk of a binary glTF file here; `finish` makes a file
/// of the chunks. Most changes to the bytes of the file would only make its lengths wrong, which readers refuse at
/// once; some are left.
std::size_t mutate_chunk(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed,
                         std::string (*finish)(Chunks chunks));

}  // namespace encage::fuzz
