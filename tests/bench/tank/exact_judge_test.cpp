// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/exact_judge.h"

#include "oracles/sampled.h"
#include "tests/bench/tank/tank_scenes.h"

#include <gtest/gtest.h>

namespace encage::tank {
namespace {

/// A box that falls by 1 onto the corner of one at rest below, turned so that a vertex meets a face.
bench::RecordedStep fall(double gap) {
  Motion resting, falling;
  falling.start.linear() = encage::test::turn_between(Eigen::Vector3d(1, 1, 1), -Eigen::Vector3d::UnitZ());
  falling.start.translation() = Eigen::Vector3d(0.1, 0.2, 1 + std::sqrt(3.0) + gap);
  falling.end = falling.start;
  falling.end.translation().z() -= 1;
  return {0, {{0, resting}, {1, falling}}};
}

TEST(ExactJudge, ConfirmsRealContactsOfEveryKind) {
  const TankBody body = test::sample_body("star");
  const Judge judge = exact_judge(body, {});
  Strategy strategy = make_strategy(body, Baseline::rebuild_kdop, CageUse::never);
  int kinds[3] = {0, 0, 0};
  for (std::uint32_t seed = 0; seed < 30; ++seed) {
    const bench::RecordedStep step = test::crowded_step(0, seed);
    for (const BodyContact& contact : strategy.detect(step).contacts) {
      const auto time = judge(step, contact);
      ASSERT_TRUE(time.has_value());
      EXPECT_GE(*time, contact.contact.time);
      EXPECT_LE(*time, contact.contact.time + time_tolerance);
      ++kinds[static_cast<int>(contact.contact.kind)];
    }
  }
  EXPECT_GT(kinds[static_cast<int>(ContactKind::vertex_face)], 3);
  EXPECT_GT(kinds[static_cast<int>(ContactKind::face_vertex)], 3);
  EXPECT_GT(kinds[static_cast<int>(ContactKind::edge_edge)], 3);
}

TEST(ExactJudge, RefutesFeaturesThatDoNotMeet) {
  const TankBody body = test::sample_body("box");
  const Judge judge = exact_judge(body, {});
  Strategy strategy = make_strategy(body, Baseline::prebuilt, CageUse::never);
  const bench::RecordedStep step = fall(0.5);
  std::vector<BodyContact> contacts = strategy.detect(step).contacts;
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_EQ(contacts[0].contact.kind, ContactKind::face_vertex);
  EXPECT_NEAR(*judge(step, contacts[0]), 0.5, 1e-9);
  EXPECT_FALSE(judge(fall(1.001), contacts[0]).has_value());
  // The opposite vertex of the falling box does not come near.
  contacts[0].contact.vertices[3] = 7 - contacts[0].contact.vertices[3];
  EXPECT_FALSE(judge(step, contacts[0]).has_value());
}

TEST(ExactJudge, MindsTheMargin) {
  const TankBody body = test::sample_body("box");
  StrategyOptions options;
  options.contact.margin = 0.01;
  Strategy strategy = make_strategy(body, Baseline::prebuilt, CageUse::never, options);
  const bench::RecordedStep step = fall(1.005);
  const std::vector<BodyContact> contacts = strategy.detect(step).contacts;
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_FALSE(exact_judge(body, {})(step, contacts[0]).has_value());
  const auto time = exact_judge(body, options.contact)(step, contacts[0]);
  ASSERT_TRUE(time.has_value());
  EXPECT_NEAR(*time, contacts[0].contact.time, time_tolerance);
}

}  // namespace
}  // namespace encage::tank
