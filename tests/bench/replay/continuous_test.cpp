// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/continuous.h"

#include "oracles/meshes.h"
#include "tests/bench/replay/bodies.h"

#include <gtest/gtest.h>

namespace encage::replay {
namespace {

bench::RecordedBody moving(std::int32_t body, double from, double to) {
  return {body, {test::body_at(body, from).pose, test::body_at(body, to).pose}};
}

TEST(Continuous, CountsPairsAndContacts) {
  const ReplayBody body = test::body_of(shapes::cube(1));
  // 0 passes through 1; 2 overlaps 3 at the start; 4 follows 5 without reaching it.
  const bench::Recording recording{1,
                                   {{0, {moving(0, 0, 20), moving(1, 10, 10)}},
                                    {1, {moving(2, 0, 1), moving(3, 1, 1), moving(4, 10, 15), moving(5, 13, 18)}}}};
  const Continuous result = continuous(*body.shape, recording, {{}, {{2, 3}}}, 2);
  EXPECT_EQ(result.steps, 2);
  EXPECT_EQ(result.left_out, 1);
  EXPECT_EQ(result.asked, 2);
  EXPECT_EQ(result.survivors, 1);
  EXPECT_EQ(result.contacts, 1);
  EXPECT_GT(result.ms_per_step, 0);
  EXPECT_GT(result.discrete_ms_per_step, 0);
}

TEST(Continuous, ReportsProgress) {
  const ReplayBody body = test::body_of(shapes::cube(1));
  const bench::Recording recording{1, {{0, {moving(0, 0, 1)}}, {1, {moving(0, 1, 2)}}}};
  std::vector<double> fractions;
  continuous(*body.shape, recording, {{}, {}}, 2, [&](double fraction) { fractions.push_back(fraction); });
  EXPECT_EQ(fractions, (std::vector<double>{0.5, 1}));
}

}  // namespace
}  // namespace encage::replay
