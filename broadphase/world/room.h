// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace encage {

/// Reserves capacity for `size` elements, so that growing to it cannot throw. The capacity grows by at least half: few
/// calls allocate, and eventually none.
template <class T>
void make_room(std::vector<T>& v, std::size_t size) {
  if (v.capacity() < size) v.reserve(std::max(size, v.capacity() + v.capacity() / 2));
}

}  // namespace encage
