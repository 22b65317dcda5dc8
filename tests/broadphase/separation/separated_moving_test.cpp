// SPDX-License-Identifier: GPL-3.0-or-later
// separated() of moving bodies: its rejects are compared with exact times of first contact.
#include "tests/broadphase/separation/ask_pairs.h"

#include <gtest/gtest.h>

namespace encage::test {
namespace {

constexpr int moving_shards = 4;

class SeparatedMoving : public testing::TestWithParam<int> {};

TEST_P(SeparatedMoving, NeverMissesAContactOfBruteForce) {
  const twins::Tally figures = ask_pairs("moving", twins::moving_pairs(), 6'000, moving_shards, GetParam());
  // The test is significant only if both answers are common, also for bodies that are close.
  EXPECT_GT(figures.rejected, figures.pairs / 5);
  EXPECT_GT(figures.close, figures.pairs / 20);
  // One in a hundred may be kept, and one more by chance: a shard has some twenty far pairs.
  EXPECT_LE(figures.far_kept, 1 + figures.far / 100);
  // With fewer samples the fractions are left to chance (sanitizers run few pairs).
  if (figures.sampled < 50) return;
  EXPECT_GT(figures.touching + figures.within_margin, figures.sampled / 10);
  EXPECT_GT(figures.far, figures.sampled / 20);
}

INSTANTIATE_TEST_SUITE_P(Shards, SeparatedMoving, testing::Range(0, moving_shards));

}  // namespace
}  // namespace encage::test
