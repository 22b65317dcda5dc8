// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace encage {

/// Sorts keys of pairs (pair_key.h) in time linear in the numbers of keys and of bodies, if no body has very many:
/// counting sort groups the keys by their first body.
class KeyOrder {
 public:
  /// Sorts keys whose first index is below `bodies`. Allocates nothing unless there are more keys than ever before.
  void sort(std::vector<std::uint64_t>& keys, std::size_t bodies);

 private:
  std::vector<std::uint32_t> ends_;
  std::vector<std::uint64_t> sorted_;
};

}  // namespace encage
