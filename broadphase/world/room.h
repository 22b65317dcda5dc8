// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace encage {

/// Room for `size` elements, so that getting there cannot throw. Grows by half as much again as before at least: few
/// calls allocate, then none.
template <class T>
void make_room(std::vector<T>& v, std::size_t size) {
  if (v.capacity() < size) v.reserve(std::max(size, v.capacity() + v.capacity() / 2));
}

}  // namespace encage
