// SPDX-License-Identifier: GPL-3.0-or-later
// Every engine against exact brute force.
#include "bench/replay/engines.h"

#include "oracles/meshes.h"
#include "tests/bench/replay/bodies.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace encage::replay {
namespace {

class Engines : public testing::TestWithParam<std::string> {
 protected:
  static std::unique_ptr<Engine> make(const ReplayBody& body) {
    std::vector<std::unique_ptr<Engine>> engines = make_engines(GetParam(), body);
    EXPECT_EQ(engines.size(), 1U);
    EXPECT_EQ(engines[0]->name(), GetParam());
    return std::move(engines[0]);
  }
};

/// Gives one answer, and notes whom it was asked about.
class OneAnswer : public Gate {
 public:
  explicit OneAnswer(bool answer) : answer_(answer) {}
  bool separated(const BodyPose& a, const BodyPose& b) const override {
    asked.push_back(make_pair(a.body, b.body));
    return answer_;
  }
  mutable std::vector<BodyPair> asked;

 private:
  bool answer_;
};

TEST_P(Engines, FindThePairsThatTouch) {
  std::size_t touching = 0;
  for (const char* name : {"star", "u", "torus"}) {
    SCOPED_TRACE(name);
    const encage::test::Sample sample = test::sample(name);
    const ReplayBody body = test::body_of(sample);
    const CageGate cages(body.shape, 0);
    const FineGate full(body.shape);
    const auto engine = make(body);
    for (const PoseStep& step : test::crowd(8)) {
      const std::vector<BodyPair> expected = test::exact_pairs(sample, step);
      const PerfectGate perfect(expected);
      EXPECT_EQ(engine->touching({step}), expected) << "step " << step.step;
      EXPECT_EQ(engine->touching({step, &cages}), expected) << "step " << step.step;
      EXPECT_EQ(engine->touching({step, &full}), expected) << "step " << step.step;
      EXPECT_EQ(engine->touching({step, &perfect}), expected) << "step " << step.step;
      touching += expected.size();
    }
  }
  EXPECT_GT(touching, 30U);
}

TEST_P(Engines, TellTouchFromNear) {
  // Two-unit cubes, turned so that nothing is parallel to an axis.
  const ReplayBody body = test::body_of(shapes::cube(1));
  const auto engine = make(body);
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()));
  const auto pairs = [&](double x) {
    BodyPose a = test::body_at(3, 0), b = test::body_at(8, x, 0.3, -0.2);
    a.pose = turn * a.pose;
    b.pose = turn * b.pose;
    const PoseStep step{0, {a, b}};
    return engine->touching({step}).size();
  };
  EXPECT_EQ(pairs(1.999), 1U);
  EXPECT_EQ(pairs(2.001), 0U);  // boxes of the world overlap
  EXPECT_EQ(pairs(1.2), 1U);
  EXPECT_EQ(pairs(50), 0U);
  EXPECT_EQ(pairs(1.999), 1U);
}

TEST_P(Engines, OnlyEncageSeesABodyInsideAnother) {
  // A small cube and a large one: moved by their offset, the small one is inside the other body's large one.
  const ReplayBody body = test::body_of(shapes::joined(shapes::cube(0.25), shapes::cube(1, {6, 0, 0})));
  const auto engine = make(body);
  const PoseStep step{0, {test::body_at(0, 0), test::body_at(1, 6)}};
  const std::size_t found = engine->touching({step}).size();
  EXPECT_EQ(found, GetParam() == "encage" ? 1U : 0U);
}

TEST_P(Engines, TestNoTrianglesOfWhatTheGateRejects) {
  const auto engine = make(test::body_of(shapes::cube(1)));
  const PoseStep step{0, {test::body_at(0, 0), test::body_at(1, 1.5), test::body_at(2, 50)}};
  const OneAnswer rejects(true), accepts(false);
  EXPECT_TRUE(engine->touching({step, &rejects}).empty());
  EXPECT_EQ(rejects.asked, std::vector<BodyPair>({{0, 1}}));
  EXPECT_EQ(engine->touching({step, &accepts}), std::vector<BodyPair>({{0, 1}}));
  EXPECT_EQ(accepts.asked, std::vector<BodyPair>({{0, 1}}));
  // What was found behind one gate says nothing of the next one.
  EXPECT_TRUE(engine->touching({step, &rejects}).empty());
}

TEST_P(Engines, LeaveOutWhatIsNotAskedFor) {
  const ReplayBody body = test::body_of(test::sample("star"));
  const auto engine = make(body);
  const PoseStep step{0, {test::body_at(0, 0), test::body_at(1, 0.5), test::body_at(2, 1)}};
  const std::vector<BodyPair> left_out = {{0, 1}, {1, 2}};
  const CageGate cages(body.shape, 0);
  EXPECT_EQ(engine->touching({step}).size(), 3U);
  EXPECT_EQ(engine->touching({step, nullptr, &left_out}), std::vector<BodyPair>({{0, 2}}));
  EXPECT_EQ(engine->touching({step, &cages, &left_out}), std::vector<BodyPair>({{0, 2}}));
}

INSTANTIATE_TEST_SUITE_P(All, Engines,
                         testing::Values("encage", "fcl", "fcl_obb", "fcl_float", "bullet", "ode", "embree_refit",
                                         "embree_rebuild"),
                         [](const auto& engine) { return engine.param; });

TEST(MakeEngines, EmbreeIsBothWaysToUpdate) {
  const auto engines = make_engines("embree", test::body_of(shapes::cube(1)));
  ASSERT_EQ(engines.size(), 2U);
  EXPECT_EQ(engines[0]->name(), "embree_refit");
  EXPECT_EQ(engines[1]->name(), "embree_rebuild");
}

TEST(MakeEngines, RefusesUnknownNames) { EXPECT_THROW(make_engines("magic", test::body_of(shapes::cube(1))), Error); }

TEST(MakeEngines, OnlyEncageGainsNothingFromItsOwnTest) {
  const ReplayBody body = test::body_of(test::sample("star"));
  const FineGate full(body.shape);
  const CageGate cages(body.shape, 0);
  EXPECT_FALSE(make_engines("encage", body)[0]->gains_from(full));
  EXPECT_TRUE(make_engines("encage", body)[0]->gains_from(cages));
  EXPECT_TRUE(make_engines("fcl", body)[0]->gains_from(full));
}

}  // namespace
}  // namespace encage::replay
