// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/strategy.h"

#include "tests/bench/tank/tank_scenes.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace encage::tank {
namespace {

constexpr Baseline baselines[] = {Baseline::rebuild_kdop, Baseline::rebuild_embree, Baseline::prebuilt};

/// All pairs of triangles of all pairs of bodies.
std::vector<BodyContact> brute_force(const TankBody& body, const bench::RecordedStep& step,
                                     const ContactOptions& options) {
  std::vector<BodyContact> contacts;
  const auto triangles = static_cast<std::int32_t>(body.mesh.mesh.triangles.rows());
  for (std::size_t i = 0; i < step.bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < step.bodies.size(); ++j) {
      PairContact narrow(*body.shape, step.bodies[i].motion, *body.shape, step.bodies[j].motion, options);
      for (std::int32_t s = 0; s < triangles; ++s) {
        for (std::int32_t t = 0; t < triangles; ++t) narrow.test(s, t);
      }
      if (narrow.first()) contacts.push_back({step.bodies[i].body, step.bodies[j].body, *narrow.first()});
    }
  }
  return contacts;
}

void expect_equal(const std::vector<BodyContact>& found, const std::vector<BodyContact>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].body_a, expected[i].body_a);
    EXPECT_EQ(found[i].body_b, expected[i].body_b);
    EXPECT_EQ(found[i].contact.time, expected[i].contact.time);
    EXPECT_EQ(found[i].contact.kind, expected[i].contact.kind);
    EXPECT_EQ(found[i].contact.vertices, expected[i].contact.vertices);
  }
}

TEST(Strategies, AllFindWhatBruteForceFinds) {
  std::int64_t contacts = 0, rejected_by_cages = 0;
  for (const char* name : {"star", "u", "two boxes"}) {
    const TankBody body = test::sample_body(name);
    for (const double margin : {0.0, 0.05}) {
      StrategyOptions options;
      options.contact.margin = margin;
      const bench::RecordedStep step = test::crowded_step(0, 3);
      const std::vector<BodyContact> expected = brute_force(body, step, options.contact);
      contacts += static_cast<std::int64_t>(expected.size());
      for (const Baseline baseline : baselines) {
        for (const CageUse cages : {CageUse::never, CageUse::always, CageUse::automatic}) {
          Strategy strategy = make_strategy(body, baseline, cages, options);
          SCOPED_TRACE(strategy.name() + " of " + name);
          const Detection detection = strategy.detect(step);
          expect_equal(detection.contacts, expected);
          EXPECT_EQ(detection.counts.pairs, 66);
          EXPECT_EQ(detection.counts.touching, static_cast<std::int64_t>(expected.size()));
          EXPECT_LE(detection.counts.boxes, 66);
          EXPECT_TRUE(cages != CageUse::never || detection.counts.cages == detection.counts.boxes);
          rejected_by_cages += detection.counts.boxes - detection.counts.cages;
        }
      }
    }
  }
  EXPECT_GT(contacts, 20);
  EXPECT_GT(rejected_by_cages, 20);
}

TEST(Strategies, AnswerTheSameAgain) {
  const TankBody body = test::sample_body("star");
  for (const Baseline baseline : baselines) {
    Strategy used = make_strategy(body, baseline, CageUse::always);
    used.detect(test::crowded_step(0, 1));
    const bench::RecordedStep step = test::crowded_step(1, 2);
    expect_equal(used.detect(step).contacts, make_strategy(body, baseline, CageUse::always).detect(step).contacts);
  }
}

TEST(Strategies, AreNamedAfterWhatTheyDo) {
  const TankBody body = test::sample_body("box");
  EXPECT_EQ(make_strategy(body, Baseline::rebuild_kdop, CageUse::never).name(), "rebuild_kdop");
  EXPECT_EQ(make_strategy(body, Baseline::rebuild_embree, CageUse::always).name(), "rebuild_embree+cages");
  EXPECT_EQ(make_strategy(body, Baseline::prebuilt, CageUse::always).name(), "prebuilt+cages");
  EXPECT_EQ(make_strategy(body, Baseline::prebuilt, CageUse::automatic).name(), "prebuilt+policy");
}

TEST(PairFilter, CountsEachBodyOnceAndLeavesPairsOut) {
  const TankBody body = test::sample_body("star");
  const bench::RecordedStep step = test::crowded_step(0, 3);
  const PairFilter filter(body, false, {});
  const Survivors all = filter.run(step);
  ASSERT_GT(all.pairs.size(), 3U);
  EXPECT_TRUE(std::is_sorted(all.pairs.begin(), all.pairs.end()));
  EXPECT_TRUE(std::adjacent_find(all.bodies.begin(), all.bodies.end(), std::greater_equal<>()) == all.bodies.end());
  for (const IndexPair& pair : all.pairs) {
    EXPECT_TRUE(std::binary_search(all.bodies.begin(), all.bodies.end(), pair.a));
    EXPECT_TRUE(std::binary_search(all.bodies.begin(), all.bodies.end(), pair.b));
  }
  const Survivors less = filter.run(step, {all.pairs[0], all.pairs[2]});
  EXPECT_EQ(less.counts.pairs, 64);
  EXPECT_EQ(less.pairs.size(), all.pairs.size() - 2);
  EXPECT_EQ(filter.run(step, all.pairs).bodies.size(), 0U);
}

TEST(PairFilter, CoarserCagesRejectLess) {
  const TankBody body = test::sample_body("star");
  StrategyOptions coarse;
  coarse.finest_cage = coarse.coarsest_cage = 2;
  std::int64_t fine_left = 0, coarse_left = 0;
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    const bench::RecordedStep step = test::crowded_step(0, seed);
    fine_left += PairFilter(body, true, {}).run(step).counts.cages;
    coarse_left += PairFilter(body, true, coarse).run(step).counts.cages;
  }
  EXPECT_LT(fine_left, coarse_left);
}

TEST(TankBody, NeedsCagesAndFineMesh) {
  const encage::test::Sample sample = encage::test::sample_shapes(0).front();
  EXPECT_THROW(make_tank_body(encage::test::without_cages(sample).hierarchy), Error);
  EXPECT_THROW(make_tank_body(encage::test::without_fine(sample).hierarchy), Error);
}

}  // namespace
}  // namespace encage::tank
