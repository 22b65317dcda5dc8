// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace encage {

/// Sorts keys of pairs (pair_key.h) in time linear in their number and that of bodies, where no body has very many:
/// those of each first body are brought together by counting.
class KeyOrder {
 public:
  /// Keys whose first index is below `bodies`. Allocates nothing unless there are more than ever before.
  void sort(std::vector<std::uint64_t>& keys, std::size_t bodies);

 private:
  std::vector<std::uint32_t> ends_;
  std::vector<std::uint64_t> sorted_;
};

}  // namespace encage
