// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/twins/run.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

namespace encage::twins {
namespace {

/// Numbers instead of bodies: apart if positive; every seventh pair is rejected wrongly.
class Numbers : public PairKind {
 public:
  Outcome ask(test::TwinRandom& random, std::int64_t number) const override {
    Outcome outcome;
    const double distance = random.uniform(-1, 1);
    outcome.sampled = number % 2 == 0;
    outcome.missed = number % 7 == 6 && distance < 0;
    outcome.rejected = distance > 0 || outcome.missed;
    outcome.truth = distance > 0 ? Truth::apart : Truth::touching;
    outcome.far = distance > 0.5;
    if (outcome.missed) outcome.what = std::to_string(distance);
    return outcome;
  }
};

/// A kind that does not end by itself.
class Failing : public PairKind {
 public:
  Outcome ask(test::TwinRandom&, std::int64_t number) const override {
    if (number == 300) throw std::runtime_error("pair 300");
    return {};
  }
};

TEST(TwinRun, FiguresDependOnTheSeedAlone) {
  const Numbers numbers;
  const std::vector<Work> works = {{"numbers", &numbers, 0, 5'000}, {"others", &numbers, 100, 777}};
  const Report one = run(works, 3, 1), two = run(works, 3, 4), other = run(works, 4, 2);
  ASSERT_EQ(one.tallies.size(), 2U);
  EXPECT_EQ(one.tallies[0].pairs, 5'000);
  EXPECT_EQ(one.tallies[0].sampled, 2'500);
  EXPECT_EQ(one.tallies[1].pairs, 777);
  EXPECT_NEAR(static_cast<double>(one.tallies[0].touching), 1'250, 150);
  EXPECT_NEAR(static_cast<double>(one.tallies[0].far), 625, 120);
  EXPECT_EQ(one.tallies[0].far_kept, 0);
  EXPECT_EQ(two.tallies[0].rejected, one.tallies[0].rejected);
  EXPECT_EQ(two.tallies[1].rejected, one.tallies[1].rejected);
  EXPECT_NE(other.tallies[0].rejected, one.tallies[0].rejected);
  ASSERT_EQ(one.misses.size(), 40U) << "the first twenty of each kind";
  ASSERT_EQ(two.misses.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) {
    EXPECT_EQ(one.misses[i].number, two.misses[i].number);
    EXPECT_EQ(one.misses[i].what, two.misses[i].what);
  }
}

TEST(TwinRun, EveryMissCanBeReplayedAlone) {
  const Numbers numbers;
  const Report all = run({{"numbers", &numbers, 0, 500}}, 9, 2);
  ASSERT_FALSE(all.misses.empty());
  for (const Miss& miss : all.misses) {
    const Report again = run({{"numbers", &numbers, miss.number, 1}}, 9, 1);
    ASSERT_EQ(again.misses.size(), 1U);
    EXPECT_EQ(again.misses[0].what, miss.what);
    EXPECT_EQ(again.tallies[0].missed, 1);
  }
}

TEST(TwinRun, AnErrorEndsIt) {
  const Failing failing;
  EXPECT_THROW(run({{"failing", &failing, 0, 1'000'000'000}}, 1, 2), std::runtime_error);
}

TEST(TwinRun, ProgressMayEndIt) {
  const Failing endless;
  const auto stop = [](double) { throw std::logic_error("enough"); };
  EXPECT_THROW(run({{"endless", &endless, 301, 1'000'000'000'000}}, 1, 2, stop), std::logic_error);
}

TEST(TwinRun, DividesPairsByShares) {
  EXPECT_EQ(divide(100, {20, 30, 50}), (std::vector<std::int64_t>{20, 30, 50}));
  EXPECT_EQ(divide(7, {1, 1, 1}), (std::vector<std::int64_t>{3, 2, 2}));
  EXPECT_EQ(divide(1, {12}), (std::vector<std::int64_t>{1}));
  const std::vector<std::int64_t> counts = divide(2'999'999, {20, 12, 3, 65});
  EXPECT_EQ(counts[0] + counts[1] + counts[2] + counts[3], 2'999'999);
}

/// Each kind is significant: both answers are common, and far pairs are rejected.
TEST(TwinKinds, MissNothingAndRejectWhatIsFar) {
  for (const KindEntry& entry : all_kinds()) {
    SCOPED_TRACE(entry.name);
    const auto kind = entry.make();
    const Report report = run({{entry.name, kind.get(), 0, 240}}, 1, 2);
    const Tally& t = report.tallies.front();
    for (const Miss& miss : report.misses) ADD_FAILURE() << miss.number << ": " << miss.what;
    EXPECT_EQ(t.missed, 0);
    EXPECT_GT(t.rejected, 10);
    EXPECT_GT(t.touching, 1);
    EXPECT_GE(t.far, 1);
    EXPECT_LE(t.far_kept * 50, t.far);
  }
}

}  // namespace
}  // namespace encage::twins
