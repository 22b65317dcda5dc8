// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/compare.h"
#include "bench/covers/report.h"
#include "oracles/sample_shapes.h"
#include "tests/bench/covers/crowd.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace encage::covers {
namespace {

TEST(Compare, NothingRejectsWhatTheFineMeshDoesNot) {
  for (const encage::test::Sample& sample : encage::test::large_sample_shapes(0)) {
    if (sample.hierarchy.fine.triangles.rows() == 0) continue;
    SCOPED_TRACE(sample.name);
    const ShapePtr shape = make_shape(sample.hierarchy);
    const Contestants contestants = make_contestants(*shape, {{10, 100}, {30, 200}});
    for (const bool moving : {false, true}) {
      const PairLists lists = make_pairs(*shape, test::crowd(20, 0.1), 2, moving);
      const Comparison result = compare(contestants, lists, 1);
      EXPECT_EQ(result.steps, 10);
      EXPECT_EQ(result.doubtful(), 0);
      ASSERT_EQ(result.scores.size(), contestants.size());
      EXPECT_EQ(result.scores.front().name, "fine mesh");
      EXPECT_GT(result.scores.front().rejected, 0);
      for (const Score& score : result.scores) {
        EXPECT_LE(score.rejected, result.scores.front().rejected) << score.name;
        EXPECT_GT(score.us_per_step, 0) << score.name;
        EXPECT_GT(score.bytes, 0U) << score.name;
        if (score.name.ends_with("fine mesh")) {
          EXPECT_EQ(score.rejected, result.scores.front().rejected) << score.name;
        }
      }
    }
  }
}

TEST(Compare, FinerBoxesRejectMore) {
  const auto samples = encage::test::large_sample_shapes(0);
  const auto torus =
      std::find_if(samples.begin(), samples.end(), [](const auto& sample) { return sample.name == "fine torus"; });
  ASSERT_NE(torus, samples.end());
  const ShapePtr shape = make_shape(torus->hierarchy);
  const Contestants contestants = make_contestants(*shape, {{}, {1, 500}});
  const Comparison result = compare(contestants, make_pairs(*shape, test::crowd(40, 0.1), 1, false), 1);
  std::vector<std::int64_t> boxes;
  for (const Score& score : result.scores) {
    if (score.name.ends_with(" boxes")) boxes.push_back(score.rejected);
  }
  ASSERT_EQ(boxes.size(), 2U);
  EXPECT_GT(boxes[0], 0);
  EXPECT_LT(boxes[0], boxes[1]);
  EXPECT_LE(boxes[1], result.scores.front().rejected);
}

TEST(PairLists, RefusesPosesWithoutSteps) {
  const ShapePtr shape = make_shape(encage::test::large_sample_shapes(0).front().hierarchy);
  EXPECT_THROW(make_pairs(*shape, {}, 1, false), Error);
  EXPECT_THROW(make_pairs(*shape, test::crowd(1, 0), 1, true), Error);
}

TEST(Report, ShowsQuotients) {
  Comparison comparison{2, 10, {{"fine mesh", 5000, 8, 8, 4}, {"3 balls", 1000, 4, 4, 1}}};
  std::ostringstream out;
  print(out, "At rest", comparison);
  EXPECT_NE(out.str().find("5.00 pairs a step, of which 4.00 can be rejected"), std::string::npos) << out.str();
  const auto json = to_json(comparison);
  const auto& balls = json.at("representations").at(1);
  EXPECT_EQ(balls.at("share"), 0.5);
  EXPECT_EQ(balls.at("ns_per_pair"), 200);
  EXPECT_EQ(balls.at("rejects_per_us"), 2);
  EXPECT_EQ(json.at("doubtful"), 0);
  comparison.scores[1].rejected = 5;
  EXPECT_EQ(comparison.doubtful(), 1);
}

}  // namespace
}  // namespace encage::covers
