// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace encage {

/// Map from numbers below a limit to numbers >= 0. Emptying it costs as much as was put in; it keeps its memory, which
/// is that of the largest limit so far.
class IndexMap {
 public:
  /// Empties the map, for keys below `limit`.
  void clear(std::size_t limit) {
    for (const std::int32_t key : keys_) values_[static_cast<std::size_t>(key)] = -1;
    keys_.clear();
    if (limit > values_.size()) values_.resize(limit, -1);
  }

  /// Returns -1 for a key that is not in the map.
  std::int32_t operator[](std::int32_t key) const { return values_[static_cast<std::size_t>(key)]; }

  /// Puts in a key that is not in the map.
  void insert(std::int32_t key, std::int32_t value) {
    values_[static_cast<std::size_t>(key)] = value;
    keys_.push_back(key);
  }

 private:
  std::vector<std::int32_t> values_, keys_;
};

}  // namespace encage
