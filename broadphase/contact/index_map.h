// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace encage {

/// Hash table from numbers >= 0 to numbers, which is emptied in constant time and keeps its memory.
class IndexMap {
 public:
  void clear() {
    size_ = 0;
    if (++round_ == 0) {
      for (Slot& slot : slots_) slot.round = 0;
      round_ = 1;
    }
  }

  /// Returns the value of a key, a reference to -1 if it is new. The reference is valid until the next call.
  std::int32_t& operator[](std::int32_t key) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    Slot& slot = slots_[position(key)];
    if (slot.round != round_) {
      slot = {key, -1, round_};
      ++size_;
    }
    return slot.value;
  }

 private:
  struct Slot {
    std::int32_t key = 0, value = -1;
    std::uint32_t round = 0;  ///< in use if it is the table's
  };

  std::size_t position(std::int32_t key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = (static_cast<std::uint32_t>(key) * 2654435769U >> 7) & mask;
    while (slots_[i].round == round_ && slots_[i].key != key) i = (i + 1) & mask;
    return i;
  }

  void grow() {
    std::vector<Slot> old(std::max<std::size_t>(64, 2 * slots_.size()));
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.round == round_) slots_[position(slot.key)] = slot;
    }
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
  std::uint32_t round_ = 1;
};

}  // namespace encage
