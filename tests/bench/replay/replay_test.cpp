// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/replay.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/bench/replay/bodies.h"

namespace encage::replay {
namespace {

/// Reports the pair (0, 3) in every step, and (6, 9) in steps that `also` divides; misses all behind a gate if so told.
class Oracle : public Engine {
 public:
  Oracle(std::string name, int also, bool blind_behind_gate = false)
      : name_(std::move(name)), also_(also), blind_behind_gate_(blind_behind_gate) {}

  std::string name() const override { return name_; }
  std::vector<BodyPair> touching(const PoseStep& step, const CageGate* gate) override {
    if (gate && blind_behind_gate_) return {};
    std::vector<BodyPair> pairs = {{0, 3}};
    if (step.step % also_ == 0) pairs.push_back({6, 9});
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

TEST(Replay, AgreementOfAll) {
  const auto engines = engines_of(std::make_unique<Oracle>("one", 2), std::make_unique<Oracle>("two", 2));
  const Replay result = replay(engines, nullptr, test::crowd(10), 3);
  EXPECT_EQ(result.steps, 10);
  ASSERT_EQ(result.engines.size(), 2U);
  EXPECT_EQ(result.engines[1].name, "two");
  EXPECT_EQ(result.engines[1].touching, 15);
  EXPECT_FALSE(result.engines[1].with_cages_ms.has_value());
  EXPECT_TRUE(result.disagreements.empty());
}

TEST(Replay, ListsPairsOnWhichEnginesDiffer) {
  const auto engines = engines_of(std::make_unique<Oracle>("one", 1), std::make_unique<Oracle>("two", 2));
  const Replay result = replay(engines, nullptr, test::crowd(4), 1);
  ASSERT_EQ(result.disagreements.size(), 2U);
  EXPECT_EQ(result.disagreements[0].step, 11);
  EXPECT_EQ(result.disagreements[0].pair, (BodyPair{6, 9}));
  EXPECT_EQ(result.disagreements[0].touching, std::vector<std::string>{"one"});
}

TEST(Replay, ListsPairsThatAreLostBehindTheGate) {
  const CageGate gate(make_shape(test::sample("box").hierarchy), 0);
  const auto engines = engines_of(std::make_unique<Oracle>("one", 5, true), std::make_unique<Oracle>("two", 5));
  const Replay result = replay(engines, &gate, test::crowd(1), 1);
  EXPECT_TRUE(result.engines[0].with_cages_ms.has_value());
  ASSERT_EQ(result.disagreements.size(), 2U);
  EXPECT_EQ(result.disagreements[1].touching, (std::vector<std::string>{"one", "two", "two+cages"}));
}

TEST(Replay, ReportsProgress) {
  const auto engines = engines_of(std::make_unique<Oracle>("one", 1), std::make_unique<Oracle>("two", 1));
  std::vector<double> fractions;
  replay(engines, nullptr, test::crowd(4), 2, [&](double fraction) { fractions.push_back(fraction); });
  ASSERT_EQ(fractions.size(), 8U);
  EXPECT_EQ(fractions.front(), 0.125);
  EXPECT_EQ(fractions.back(), 1);
}

}  // namespace
}  // namespace encage::replay
