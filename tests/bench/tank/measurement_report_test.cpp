// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/measurement_report.h"

#include <gtest/gtest.h>

#include <string>

namespace encage::tank {
namespace {

Measurement sample() {
  Measurement m;
  m.steps = 100;
  m.sampled_steps = 10;
  m.left_out = 3;
  m.counts = {1000, 200, 50, 20};
  m.oracle_bodies = 40;
  double ms = 64;
  for (const char* name : {"rebuild_kdop", "rebuild_kdop+cages", "rebuild_embree", "rebuild_embree+cages", "prebuilt",
                           "prebuilt+cages", "prebuilt+policy"}) {
    StrategyResult& r = m.strategies.emplace_back();
    r.name = name;
    r.rebuilds = r.name.starts_with("rebuild");
    r.steps_timed = r.rebuilds ? 10 : 100;
    r.ms_per_step = ms;
    r.sampled_ms = ms;
    r.bodies = r.name.ends_with("+cages") ? 100 : 300;
    r.counts = {100, 30, 20, 5};
    ms /= 2;
  }
  m.strategies[1].faults = {1, 2};
  return m;
}

TEST(MeasurementReport, JsonHasTheKeysThatOthersRelyOn) {
  const nlohmann::ordered_json json = to_json(sample());
  const auto& kdop = json.at("strategies").at("rebuild_kdop");
  EXPECT_EQ(kdop.at("detect_ms_per_step"), 64);
  EXPECT_EQ(kdop.at("steps_timed"), 10);
  EXPECT_EQ(kdop.at("bodies_rebuilt_per_step"), 3);
  EXPECT_EQ(kdop.at("rejects_by_stage").at("boxes"), 7);
  EXPECT_EQ(kdop.at("rejects_by_stage").at("cages"), 1);
  EXPECT_EQ(kdop.at("rejects_by_stage").at("triangles"), 1.5);
  EXPECT_EQ(json.at("strategies").at("prebuilt").at("bodies_rebuilt_per_step"), 0);
  EXPECT_EQ(json.at("strategies").size(), 7U);
  EXPECT_EQ(json.at("oracle_bodies_per_step"), 0.4);
  EXPECT_EQ(json.at("speedup_paper"), 2);
  EXPECT_EQ(json.at("speedup_embree"), 2);
  EXPECT_EQ(json.at("speedup_policy"), 4);
  EXPECT_EQ(json.at("prebuilt_over_kdop"), 16);
  EXPECT_EQ(json.at("prebuilt_over_embree_cages"), 2);
  EXPECT_EQ(json.at("speedup_count"), 3);
  EXPECT_EQ(json.at("missed_contacts"), 1);
  EXPECT_EQ(json.at("spurious"), 2);
  EXPECT_EQ(json.at("left_out_pairs"), 3);
}

TEST(MeasurementReport, WithoutASampleThereAreNoRatiosOfTimes) {
  Measurement m = sample();
  m.sampled_steps = 0;
  m.strategies.erase(m.strategies.begin(), m.strategies.begin() + 4);
  EXPECT_FALSE(to_json(m).contains("speedup_paper"));
  EXPECT_EQ(to_json(m).at("speedup_count"), 3);
  EXPECT_EQ(to_text(m).find("rebuild_kdop"), std::string::npos);
}

TEST(MeasurementReport, TextNamesStrategiesAndRatios) {
  const std::string text = to_text(sample());
  for (const char* part : {"rebuild_embree+cages", "rebuild_kdop / rebuild_kdop+cages",
                           "rebuild_embree+cages / prebuilt", "an oracle: 0.400", "left out: 3 times"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
  }
}

}  // namespace
}  // namespace encage::tank
