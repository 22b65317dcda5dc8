// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/glb_mutator.h"

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  using namespace encage::fuzz;
  return mutate_chunk(data, size, max_size, seed, [](Chunks chunks) { return join(chunks, 4); });
}
