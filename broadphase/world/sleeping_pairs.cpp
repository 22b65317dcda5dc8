// SPDX-License-Identifier: Apache-2.0
#include "broadphase/world/sleeping_pairs.h"

#include "broadphase/world/room.h"

namespace encage {

void SleepingPairs::prepare_add(std::size_t bodies, std::size_t half_spaces, std::size_t pairs) {
  make_room(nodes_, size_ + pairs);
  make_room(heads_[0], bodies);
  make_room(heads_[1], half_spaces);
  if (heads_[0].size() < bodies) heads_[0].resize(bodies, -1);
  if (heads_[1].size() < half_spaces) heads_[1].resize(half_spaces, -1);
}

void SleepingPairs::make_room_for(const SleepingPairs& other) {
  make_room(nodes_, other.nodes_.size());
  for (std::size_t i = 0; i < heads_.size(); ++i) make_room(heads_[i], other.heads_[i].size());
}

std::int32_t& SleepingPairs::head(std::uint64_t key, int side) noexcept {
  const std::uint32_t owner = side == 0 ? first_of(key) : second_of(key);
  return heads_[owner >> 31][owner & ~half_space_bit];
}

std::size_t SleepingPairs::count(std::uint32_t owner) const noexcept {
  const std::vector<std::int32_t>& heads = heads_[owner >> 31];
  const std::uint32_t i = owner & ~half_space_bit;
  std::size_t sum = 0;
  for (std::int32_t end = i < heads.size() ? heads[i] : -1; end >= 0; end = nodes_[end / 2].links[end % 2].next) ++sum;
  return sum;
}

void SleepingPairs::add(std::uint64_t key) noexcept {
  std::int32_t node = free_;
  if (node < 0) {
    node = static_cast<std::int32_t>(nodes_.size());
    nodes_.emplace_back();  // prepare_add() has reserved it
  } else {
    free_ = nodes_[node].links[0].next;
  }
  nodes_[node].key = key;
  for (int side = 0; side < 2; ++side) {
    std::int32_t& first = head(key, side);
    const std::int32_t end = 2 * node + side;
    link(end) = {.next = first, .previous = -1};
    if (first >= 0) link(first).previous = end;
    first = end;
  }
  ++size_;
}

std::uint64_t SleepingPairs::remove(std::int32_t node) noexcept {
  const std::uint64_t key = nodes_[node].key;
  for (int side = 0; side < 2; ++side) {
    const Link gone = link(2 * node + side);
    if (gone.next >= 0) link(gone.next).previous = gone.previous;
    (gone.previous >= 0 ? link(gone.previous).next : head(key, side)) = gone.next;
  }
  nodes_[node].links[0].next = free_;
  free_ = node;
  --size_;
  return key;
}

}  // namespace encage
