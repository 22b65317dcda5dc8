// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/measure.h"

#include "tests/bench/tank/tank_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

namespace encage::tank {
namespace {

bench::Recording crowd(std::int64_t steps) {
  bench::Recording recording{1, {}};
  for (std::int64_t i = 0; i < steps; ++i) {
    recording.steps.push_back(test::crowded_step(i, static_cast<std::uint32_t>(i)));
  }
  return recording;
}

class Measured : public testing::Test {
 protected:
  Measured() {
    options.rebuild_steps = 4;
    options.runs = 2;
  }

  TankBody body = test::sample_body("star");
  bench::Recording recording = crowd(9);
  MeasureOptions options;
};

TEST_F(Measured, PrebuiltOnAllStepsTheOthersOnTheSample) {
  const Measurement m = measure(body, recording, options);
  EXPECT_EQ(m.steps, 9);
  EXPECT_EQ(m.sampled_steps, 4);
  ASSERT_EQ(m.strategies.size(), 7U);
  for (const StrategyResult& r : m.strategies) {
    EXPECT_EQ(r.steps_timed, r.rebuilds ? 4 : 9) << r.name;
    EXPECT_GT(r.ms_per_step, 0) << r.name;
    EXPECT_GT(r.sampled_ms, 0) << r.name;
    EXPECT_EQ(r.faults, Faults{}) << r.name;
  }
  EXPECT_TRUE(m.strategy("rebuild_kdop").rebuilds);
  EXPECT_FALSE(m.strategy("prebuilt+cages").rebuilds);
  EXPECT_EQ(m.speedup("rebuild_kdop", "prebuilt"),
            m.strategy("rebuild_kdop").sampled_ms / m.strategy("prebuilt").sampled_ms);
  EXPECT_THROW(m.strategy("magic"), std::out_of_range);
}

TEST_F(Measured, CountsBodiesOverAllSteps) {
  const Measurement m = measure(body, recording, options);
  Strategy without = make_strategy(body, Baseline::prebuilt, CageUse::never),
           with = make_strategy(body, Baseline::prebuilt, CageUse::always);
  std::int64_t bodies = 0, bodies_with_cages = 0, oracle = 0, left_out = 0;
  StageCounts counts;
  for (const bench::RecordedStep& step : recording.steps) {
    const std::vector<IndexPair> out = pairs_in_contact_at_start(body, step);
    left_out += static_cast<std::int64_t>(out.size());
    bodies += without.detect(step, out).bodies;
    const Detection detection = with.detect(step, out);
    bodies_with_cages += detection.bodies;
    counts += detection.counts;
    std::set<std::int32_t> touching;
    for (const BodyContact& contact : detection.contacts) touching.insert({contact.body_a, contact.body_b});
    oracle += static_cast<std::int64_t>(touching.size());
  }
  EXPECT_EQ(m.left_out, left_out);
  EXPECT_EQ(m.strategy("rebuild_kdop").bodies, bodies);
  EXPECT_EQ(m.strategy("rebuild_embree+cages").bodies, bodies_with_cages);
  EXPECT_EQ(m.oracle_bodies, oracle);
  EXPECT_EQ(m.counts.cages, counts.cages);
  EXPECT_GT(m.speedup_count(), 1);
  EXPECT_GT(left_out, 0);
  EXPECT_GT(oracle, 0);
  EXPECT_LT(oracle, bodies_with_cages);
}

TEST_F(Measured, AsksTheJudgeAboutEveryContact) {
  std::int64_t asked = 0;
  options.judge = [&](const bench::RecordedStep&, const BodyContact&) {
    ++asked;
    return std::optional<double>();
  };
  options.rebuild_steps = 0;
  const Measurement m = measure(body, recording, options);
  EXPECT_EQ(asked, m.counts.touching);
  EXPECT_EQ(m.faults(), (Faults{0, 3 * asked}));
}

TEST_F(Measured, WithoutSampleNothingIsRebuilt) {
  options.rebuild_steps = 0;
  const Measurement m = measure(body, recording, options);
  EXPECT_EQ(m.strategies.size(), 3U);
  EXPECT_EQ(m.speedup("rebuild_kdop", "prebuilt"), 0);
  EXPECT_GT(m.speedup_count(), 1);
}

TEST_F(Measured, PairsInContactAtTheStartAreLeftOut) {
  bench::RecordedStep step = recording.steps[0];
  step.bodies[4].motion = step.bodies[1].motion;
  const std::vector<IndexPair> pairs = pairs_in_contact_at_start(body, step);
  EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
  EXPECT_TRUE(std::binary_search(pairs.begin(), pairs.end(), IndexPair{1, 4}));
}

TEST_F(Measured, ReportsProgressOfEachStage) {
  std::set<std::string> stages;
  options.progress = [&](double fraction, std::string_view stage) {
    EXPECT_GT(fraction, 0);
    EXPECT_LE(fraction, 1);
    stages.emplace(stage);
  };
  measure(body, recording, options);
  EXPECT_EQ(stages.size(), 4U);
}

}  // namespace
}  // namespace encage::tank
