// SPDX-License-Identifier: Apache-2.0
#include "broadphase/world/triangle_lists.h"

#include <algorithm>

namespace encage {

void TriangleLists::clear() {
  if (!blocks_) blocks_ = std::make_unique<Block[]>(block_count);
  used_.store(0, std::memory_order_relaxed);
}

std::int32_t TriangleLists::take_block() noexcept {
  // This is tested first, so that failures do not increase the counter without end.
  if (used_.load(std::memory_order_relaxed) >= block_count) return -1;
  const std::int32_t block = used_.fetch_add(1, std::memory_order_relaxed);
  return block < block_count ? block : -1;
}

bool TriangleLists::Writer::push(TrianglePair pair) noexcept {
  if (!list_.complete()) return false;
  const int slot = list_.size % block_size;
  if (slot == 0) {
    const std::int32_t block = lists_.take_block();
    if (block < 0) {
      list_.size = -1;
      return false;
    }
    (list_.size == 0 ? list_.first_block : lists_.blocks_[block_].next) = block;
    block_ = block;
  }
  lists_.blocks_[block_].pairs[slot] = pair;
  ++list_.size;
  return true;
}

std::span<const TrianglePair> TriangleLists::read(const List& list, std::vector<TrianglePair>& room) const {
  if (list.size == 0) return {};
  const Block* block = &blocks_[list.first_block];
  if (list.size <= block_size) return {block->pairs.data(), static_cast<std::size_t>(list.size)};
  room.clear();
  for (std::int32_t left = list.size;;) {
    const std::int32_t size = std::min(left, block_size);
    room.insert(room.end(), block->pairs.begin(), block->pairs.begin() + size);
    left -= size;
    if (left == 0) return room;
    block = &blocks_[block->next];
  }
}

}  // namespace encage
