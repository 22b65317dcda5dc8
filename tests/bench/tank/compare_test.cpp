// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/compare.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

namespace encage::tank {
namespace {

struct Reported {
  std::int32_t a, b;
  double time;
};

Detection detection(const std::vector<Reported>& contacts) {
  Detection result;
  for (const Reported& c : contacts) {
    BodyContact& contact = result.contacts.emplace_back();
    contact.body_a = c.a;
    contact.body_b = c.b;
    contact.contact.time = c.time;
  }
  return result;
}

std::vector<Faults> compare_with(const Judge& judge, const std::vector<Detection>& answers) {
  std::vector<const Detection*> pointers;
  for (const Detection& answer : answers) pointers.push_back(&answer);
  return compare({}, pointers, judge);
}

std::optional<double> believe(const bench::RecordedStep&, const BodyContact& contact) { return contact.contact.time; }
std::optional<double> refute(const bench::RecordedStep&, const BodyContact&) { return std::nullopt; }

TEST(Compare, EqualAnswersHaveNoFaults) {
  const Detection answer = detection({{0, 1, 0.5}, {2, 7, 0.25}});
  for (const Faults& faults : compare_with(believe, {answer, answer, answer})) EXPECT_EQ(faults, Faults{});
}

TEST(Compare, AContactThatOnlyOthersReportIsMissed) {
  const std::vector<Faults> faults =
      compare_with(believe, {detection({{0, 1, 0.5}, {2, 7, 0.25}}), detection({{0, 1, 0.5}})});
  EXPECT_EQ(faults[0], (Faults{0, 0}));
  EXPECT_EQ(faults[1], (Faults{1, 0}));
}

TEST(Compare, ALaterTimeIsMissed) {
  const std::vector<Faults> faults = compare_with(believe, {detection({{0, 1, 0.5}}), detection({{0, 1, 0.25}})});
  EXPECT_EQ(faults[0], (Faults{1, 0}));
  EXPECT_EQ(faults[1], (Faults{0, 0}));
}

TEST(Compare, AContactThatDoesNotHappenIsSpurious) {
  const std::vector<Faults> faults = compare_with(refute, {detection({{0, 1, 0.5}}), detection({})});
  EXPECT_EQ(faults[0], (Faults{0, 1}));
  EXPECT_EQ(faults[1], (Faults{0, 0}));
}

TEST(Compare, ATimeTooEarlyIsSpurious) {
  const Judge at_half = [](const bench::RecordedStep&, const BodyContact&) { return std::optional(0.5); };
  const std::vector<Faults> faults =
      compare_with(at_half, {detection({{0, 1, 0.4}}), detection({{0, 1, 0.5 - 0.5 * time_tolerance}})});
  EXPECT_EQ(faults[0], (Faults{0, 1}));
  EXPECT_EQ(faults[1], (Faults{0, 0}));
}

TEST(Compare, AgreementIsNoProof) {
  const Detection answer = detection({{0, 1, 0.5}});
  for (const Faults& faults : compare_with(refute, {answer, answer})) EXPECT_EQ(faults, (Faults{0, 1}));
}

TEST(Compare, FaultsAddUp) {
  Faults sum{1, 2};
  sum += {3, 5};
  EXPECT_EQ(sum, (Faults{4, 7}));
}

}  // namespace
}  // namespace encage::tank
