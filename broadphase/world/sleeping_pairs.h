// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/world/pair_key.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace encage {

/// A set of pairs, with a list for each body and half-space: taking the pairs of one takes time linear in their number.
class SleepingPairs {
 public:
  /// Reserves capacity for `pairs` more, whose bodies and half-spaces have indices below the given numbers.
  void prepare_add(std::size_t bodies, std::size_t half_spaces, std::size_t pairs);
  void make_room_for(const SleepingPairs& other);

  /// Adds a pair that is not in the set.
  void add(std::uint64_t key) noexcept;

  /// Removes the pairs of a body (its index) or half-space (half_space_bit | its index); calls visit(key) for each.
  template <class Visit>
  void take(std::uint32_t owner, Visit&& visit) {
    std::vector<std::int32_t>& heads = heads_[owner >> 31];
    const std::uint32_t i = owner & ~half_space_bit;
    if (i >= heads.size()) return;
    while (heads[i] >= 0) visit(remove(heads[i] / 2));
  }

  /// Counts the pairs of a body or half-space, one by one.
  std::size_t count(std::uint32_t owner) const noexcept;
  std::size_t size() const noexcept { return size_; }

 private:
  // Ends of pairs are numbered 2 pair + side.
  struct Link {
    std::int32_t next = -1;
    std::int32_t previous = -1;
  };
  struct Node {
    std::uint64_t key = 0;
    std::array<Link, 2> links;  // in a free node, links[0].next is the next free node
  };
  Link& link(std::int32_t end) noexcept { return nodes_[end / 2].links[end % 2]; }
  std::int32_t& head(std::uint64_t key, int side) noexcept;
  std::uint64_t remove(std::int32_t node) noexcept;

  std::vector<Node> nodes_;
  std::array<std::vector<std::int32_t>, 2> heads_;  // first ends, for bodies and for half-spaces
  std::int32_t free_ = -1;
  std::size_t size_ = 0;
};

}  // namespace encage
