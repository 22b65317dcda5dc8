// SPDX-License-Identifier: Apache-2.0
#include "broadphase/world/key_order.h"

#include "broadphase/world/pair_key.h"
#include "broadphase/world/room.h"

#include <algorithm>
#include <cstddef>
#include <limits>

namespace encage {

void KeyOrder::sort(std::vector<std::uint64_t>& keys, std::size_t bodies) {
  // Counting takes a pass over all bodies, which few keys do not pay for.
  if (keys.size() < bodies / 16 || keys.size() > std::numeric_limits<std::uint32_t>::max()) {
    std::sort(keys.begin(), keys.end());
    return;
  }
  make_room(ends_, bodies + 1);
  make_room(sorted_, keys.size());
  ends_.assign(bodies + 1, 0);
  sorted_.resize(keys.size());
  for (const std::uint64_t key : keys) ++ends_[first_of(key) + 1];
  for (std::size_t n = 0; n < bodies; ++n) ends_[n + 1] += ends_[n];
  // ends_[n] is the position for the next key of body n; after the last one, the end of its keys.
  for (const std::uint64_t key : keys) sorted_[ends_[first_of(key)]++] = key;
  auto begin = sorted_.begin();
  for (std::size_t n = 0; n < bodies; ++n) {
    const auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(ends_[n]);
    std::sort(begin, end);
    begin = end;
  }
  keys.swap(sorted_);
}

}  // namespace encage
