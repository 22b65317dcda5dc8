// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/glb_mutator.h"

#include <cstring>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

// Most changes to the bytes of a container only make its lengths wrong, which the reader refuses at once.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  using namespace encage::fuzz;
  std::optional<Chunks> chunks;
  if (seed % 8 != 0) chunks = split({reinterpret_cast<const char*>(data), size});
  if (!chunks) return LLVMFuzzerMutate(data, size, max_size);
  mutate(*chunks, max_size, seed / 8);
  const std::string bytes = join(*chunks, 4);
  if (bytes.size() > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memcpy(data, bytes.data(), bytes.size());
  return bytes.size();
}
