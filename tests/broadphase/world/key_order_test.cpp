// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/world/key_order.h"

#include "broadphase/world/pair_key.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace encage::test {
namespace {

TEST(KeyOrders, SortLikeTheStandardLibrary) {
  KeyOrder order;
  std::minstd_rand random(3);
  for (const std::uint32_t bodies : {1u, 2u, 17u, 1000u}) {
    for (const std::size_t count : {0u, 1u, 5u, 62u, 63u, 64u, 700u, 5000u}) {
      for (const bool crowded : {false, true}) {
        std::vector<std::uint64_t> keys;
        for (std::size_t i = 0; i < count; ++i) {
          const auto any = [&] { return static_cast<std::uint32_t>(random() % bodies); };
          const std::uint32_t a = crowded ? bodies - 1 : any(), b = any();
          keys.push_back(random() % 4 == 0 ? pair_key(a, half_space_bit | b) : pair_key(a, b));
        }
        std::vector<std::uint64_t> expected = keys;
        std::sort(expected.begin(), expected.end());
        order.sort(keys, bodies);
        ASSERT_EQ(keys, expected) << bodies << " bodies, " << count << " keys";
      }
    }
  }
}

}  // namespace
}  // namespace encage::test
