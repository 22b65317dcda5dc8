// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace encage::bench {
namespace {

TEST(Median, IsTheMiddleValue) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({9, 1, 4}), 4);
  EXPECT_EQ(median({9, 1, 4, 2}), 3);
  EXPECT_EQ(median({5, 5, 1, 5}), 5);
  EXPECT_EQ(median({}), 0);
}

TEST(MeanOfMedians, CountsEveryListOnce) {
  EXPECT_EQ(mean_of_medians({{1, 100, 2}, {9, 4, 0}}), 3);
  EXPECT_EQ(mean_of_medians({{6}, {}}), 3);
  EXPECT_EQ(mean_of_medians({}), 0);
}

TEST(Ratio, OfWhatWasNotTimedIsZero) {
  EXPECT_EQ(ratio(6, 4), 1.5);
  EXPECT_EQ(ratio(6, 0), 0);
}

TEST(GrowthExponent, FindsThePower) {
  const std::vector<double> x = {1000, 3000, 10'000, 100'000};
  std::vector<double> y;
  for (const double v : x) y.push_back(7 * std::pow(v, 1.25));
  EXPECT_NEAR(growth_exponent(x, y), 1.25, 1e-12);
  EXPECT_EQ(growth_exponent({5}, {3}), 0);
  EXPECT_EQ(growth_exponent({}, {}), 0);
}

TEST(EvenlySpread, CoversTheRange) {
  EXPECT_EQ(evenly_spread(10, 5), (std::vector<std::int64_t>{1, 3, 5, 7, 9}));
  EXPECT_EQ(evenly_spread(3, 7), (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(evenly_spread(1000, 1), (std::vector<std::int64_t>{500}));
  EXPECT_TRUE(evenly_spread(0, 4).empty());
  EXPECT_TRUE(evenly_spread(4, 0).empty());
}

}  // namespace
}  // namespace encage::bench
