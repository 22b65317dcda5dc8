// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/replay.h"

#include "tests/bench/replay/bodies.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace encage::replay {
namespace {

/// Reports the pair (0, 3) in every step, and (6, 9) in steps that `also` divides; misses all behind a gate if so told.
class Oracle : public Engine {
 public:
  Oracle(std::string name, int also, bool blind_behind_gate = false)
      : name_(std::move(name)), also_(also), blind_behind_gate_(blind_behind_gate) {}

  std::string name() const override { return name_; }
  std::vector<BodyPair> touching(const StepQuestion& question) override {
    if (question.gate && blind_behind_gate_) return {};
    std::vector<BodyPair> pairs = {{0, 3}};
    if (question.step.step % also_ == 0) pairs.push_back({6, 9});
    std::erase_if(pairs,
                  [&](const BodyPair& p) { return question.leaves_out(test::body_at(p.a, 0), test::body_at(p.b, 0)); });
    return pairs;
  }

 private:
  std::string name_;
  int also_;
  bool blind_behind_gate_;
};

std::vector<std::unique_ptr<Engine>> engines_of(std::unique_ptr<Engine> a, std::unique_ptr<Engine> b) {
  std::vector<std::unique_ptr<Engine>> engines;
  engines.push_back(std::move(a));
  engines.push_back(std::move(b));
  return engines;
}

/// The truth: (0, 3) in every step, and (6, 9) in steps that 2 divides.
PairQuestion question_of(int steps, int runs, std::vector<Front> fronts = {}) {
  PairQuestion question{test::crowd(steps), {}, {}, std::move(fronts), runs};
  for (const PoseStep& step : question.steps) question.truth.push_back(Oracle("", 2).touching({step}));
  return question;
}

TEST(Replay, AgreementOfAll) {
  const auto engines = engines_of(std::make_unique<Oracle>("one", 2), std::make_unique<Oracle>("two", 2));
  const Replay result = replay(engines, question_of(10, 3));
  EXPECT_EQ(result.steps, 10);
  EXPECT_EQ(result.touching, 15);
  ASSERT_EQ(result.engines.size(), 2U);
  EXPECT_EQ(result.engines[1].name, "two");
  EXPECT_EQ(result.engines[1].alone.touching, 15);
  EXPECT_TRUE(result.engines[1].behind.empty());
  EXPECT_TRUE(result.disagreements.empty());
}

TEST(Replay, SaysWhoIsWrong) {
  const auto engines = engines_of(std::make_unique<Oracle>("all", 1), std::make_unique<Oracle>("few", 20));
  const Replay result = replay(engines, question_of(3, 1));
  EXPECT_EQ(result.engines[0].alone.missed, 0);
  EXPECT_EQ(result.engines[0].alone.spurious, 1);
  EXPECT_EQ(result.engines[1].alone.missed, 2);
  EXPECT_EQ(result.engines[1].alone.spurious, 0);
  ASSERT_EQ(result.disagreements.size(), 3U);
  EXPECT_EQ(result.disagreements[1].step, 11);
  EXPECT_EQ(result.disagreements[1].pair, (BodyPair{6, 9}));
  EXPECT_FALSE(result.disagreements[1].truth);
  EXPECT_EQ(result.disagreements[1].touching, std::vector<std::string>{"all"});
  EXPECT_TRUE(result.disagreements[2].truth);
}

TEST(Replay, ListsWhatAllGetWrong) {
  const auto engines = engines_of(std::make_unique<Oracle>("one", 20), std::make_unique<Oracle>("two", 20));
  const Replay result = replay(engines, question_of(1, 1));
  ASSERT_EQ(result.disagreements.size(), 1U);
  EXPECT_TRUE(result.disagreements[0].truth);
  EXPECT_TRUE(result.disagreements[0].touching.empty());
}

TEST(Replay, ListsPairsThatAreLostBehindAFront) {
  const CageGate gate(make_shape(test::sample("box").hierarchy), 0);
  const auto engines = engines_of(std::make_unique<Oracle>("one", 2, true), std::make_unique<Oracle>("two", 2));
  const Replay result = replay(engines, question_of(1, 1, {{"cages", &gate}}));
  ASSERT_EQ(result.engines[0].behind.size(), 1U);
  EXPECT_EQ(result.engines[0].behind[0].front, "cages");
  EXPECT_EQ(result.engines[0].behind[0].missed, 2);
  EXPECT_EQ(result.engines[0].alone.missed, 0);
  ASSERT_EQ(result.disagreements.size(), 2U);
  EXPECT_EQ(result.disagreements[1].touching, (std::vector<std::string>{"one", "two", "two+cages"}));
}

TEST(Replay, HandsOnWhatIsLeftOut) {
  const auto engines = engines_of(std::make_unique<Oracle>("one", 2), std::make_unique<Oracle>("two", 2));
  PairQuestion question = question_of(2, 1);
  question.left_out = {{{0, 3}}, {}};
  question.truth[0] = {{6, 9}};
  const Replay result = replay(engines, question);
  EXPECT_EQ(result.left_out, 1);
  EXPECT_EQ(result.touching, 2);
  EXPECT_EQ(result.engines[0].alone.touching, 2);
  EXPECT_TRUE(result.disagreements.empty());
}

TEST(Replay, ReportsProgress) {
  const auto engines = engines_of(std::make_unique<Oracle>("one", 1), std::make_unique<Oracle>("two", 1));
  std::vector<double> fractions;
  replay(engines, question_of(4, 2), [&](double fraction) { fractions.push_back(fraction); });
  ASSERT_EQ(fractions.size(), 32U);  // two engines, alone and behind what is perfect
  EXPECT_EQ(fractions.front(), 1.0 / 32);
  EXPECT_EQ(fractions.back(), 1);
}

}  // namespace
}  // namespace encage::replay
