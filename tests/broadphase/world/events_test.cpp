// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/world/twin.h"

namespace encage::test {
namespace {

using What = Found::What;

/// Abbreviates the events of a search about two bodies or about a body and a half-space: "0-1+" begins, "0-1="
/// persists, "0|0-" ends.
std::string told(World& world, const CandidateOptions& options = {}) {
  std::string text;
  for (const Found& f : events(world, options)) {
    const auto id = [](std::uint32_t i, std::uint32_t g) {
      return std::to_string(i) + (g == 0 ? "" : "'" + std::to_string(g));
    };
    text += (text.empty() ? "" : " ") + id(f.a, f.generation_a) + (f.half_space ? "|" : "~");
    text += id(f.b, f.generation_b) + (f.what == What::ends ? "-" : f.what == What::begins ? "+" : "=");
  }
  return text;
}

TEST(WorldEvents, AreThoseOfBruteForceWhateverTheHistory) {
  std::int64_t ends = 0, begins = 0, persists = 0, left_out = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    Twin twin(seed);
    std::minstd_rand random(seed);
    for (int i = 0; i < 40; ++i) twin.add_body();
    for (int step = 0; step < 40 && !testing::Test::HasFailure(); ++step) {
      if (step % 5 != 0) {
        for (int i = 0; i < 8; ++i) twin.change(1 + static_cast<unsigned>(random() % (Twin::last - 1)));
      }
      // More and more bodies fall asleep, then many wake.
      for (int i = 0; i < (step % 10 == 9 ? 20 : 4); ++i) twin.change(Twin::awake);
      if (step % 3 == 0) twin.change(Twin::remove);
      if (step % 4 == 0) twin.add_body();
      if (step == 20) twin.add_half_space();
      CandidateOptions options;
      if (step / 8 % 2 == 1) options.pair.margin = 0.02 * step;
      CandidateStatistics counts;
      const std::vector<Found> expected = twin.brute_force(options.pair);
      ASSERT_EQ(events(twin.world, options, &counts), expected) << "seed " << seed << ", step " << step;
      ends += std::count_if(expected.begin(), expected.end(), [](const Found& f) { return f.what == What::ends; });
      begins += std::count_if(expected.begin(), expected.end(), [](const Found& f) { return f.what == What::begins; });
      persists +=
          std::count_if(expected.begin(), expected.end(), [](const Found& f) { return f.what == What::persists; });
      left_out += twin.left_out();
    }
  }
  EXPECT_GT(ends, 500);
  EXPECT_GT(begins, 500);
  EXPECT_GT(persists, 500);
  EXPECT_GT(left_out, 500);
}

/// Two boxes of half edge 1 that overlap.
class WorldPairs : public testing::Test {
 protected:
  World world;
  ShapeId box = world.add_shape(sample_shape("box"));
  BodyId a = world.add_body(box, shift(0));
  BodyId b = world.add_body(box, shift(1));
};

TEST_F(WorldPairs, BeginPersistAndEnd) {
  EXPECT_EQ(told(world), "0~1+");
  EXPECT_EQ(told(world), "0~1=");
  world.set_pose(b, shift(1.5));
  EXPECT_EQ(told(world), "0~1=");
  world.set_pose(b, shift(2.05));  // the boxes in the tree still overlap
  EXPECT_EQ(told(world), "0~1-");
  EXPECT_EQ(told(world), "");
  world.set_pose(b, shift(1));
  EXPECT_EQ(told(world), "0~1+");
  world.set_pose(b, shift(50));
  EXPECT_EQ(told(world), "0~1-");
  EXPECT_EQ(told(world), "");
  // The previous search counts, whatever its options.
  EXPECT_EQ(told(world, {.pair = {.margin = 48.5}}), "0~1+");
  EXPECT_EQ(told(world), "0~1-");
}

TEST_F(WorldPairs, NameWhatEndedAndWhyItDid) {
  const HalfSpaceId floor = world.add_half_space({Vector::UnitZ(), 0});
  std::vector<CandidatePair> ended;
  const auto search = [&] {
    ended.clear();
    world.find_candidates({.ended = [&](const CandidatePair& pair) { ended.push_back(pair); }},
                          [](const CandidatePair&) {});
  };
  search();
  EXPECT_TRUE(ended.empty());
  world.set_pose(b, shift(2.05, 0, 1.01));
  search();
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0].a, a);
  EXPECT_EQ(ended[0].b, b);
  EXPECT_EQ(ended[0].event, PairEvent::end);
  EXPECT_TRUE(ended[0].verdict.separated);
  EXPECT_EQ(ended[1].a, b);
  EXPECT_EQ(ended[1].half_space, floor);
  world.remove_half_space(floor);
  search();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].a, a);
  EXPECT_EQ(ended[0].b, BodyId::none);
  EXPECT_EQ(ended[0].half_space, floor);
  EXPECT_FALSE(ended[0].verdict.separated);
}

TEST_F(WorldPairs, EndUnderTheirOldIds) {
  world.add_half_space({Vector::UnitX(), -0.5});
  EXPECT_EQ(told(world), "0~1+ 0|0+");
  world.remove_body(a);
  const BodyId again = world.add_body(box, shift(0.1));
  EXPECT_EQ(index(again), 0u);
  EXPECT_EQ(told(world), "0~1- 0'1~1+ 0|0- 0'1|0+");
  world.remove_half_space(HalfSpaceId{0});
  world.add_half_space({Vector::UnitX(), -0.6});
  EXPECT_EQ(told(world), "0'1~1= 0'1|0- 0'1|0'1+");
  // A body that was added and removed between two searches causes no event.
  world.remove_body(again);
  world.remove_body(world.add_body(box, shift(0)));
  world.add_body(box, shift(30));
  EXPECT_EQ(told(world), "0'1~1- 0'1|0'1-");
  world.remove_body(b);
  EXPECT_EQ(told(world), "");
}

TEST_F(WorldPairs, EndWhereAPairIsNoLongerWanted) {
  EXPECT_EQ(told(world), "0~1+");
  world.set_filter(b, {1, 0});
  EXPECT_EQ(told(world), "0~1-");
  world.set_options(b, {.group = 2});
  EXPECT_EQ(told(world), "0~1+");
  world.set_options(b, {.kind = BodyKind::kinematic});
  world.set_options(a, {.kind = BodyKind::static_});
  EXPECT_EQ(told(world), "0~1-");
  world.set_options(a, {});
  EXPECT_EQ(told(world), "0~1+");
  const CandidateOptions none{.accept = [](const CandidatePair& pair) {
    EXPECT_EQ(pair.event, PairEvent::persist);
    return false;
  }};
  EXPECT_EQ(told(world, none), "0~1-");
  EXPECT_EQ(told(world), "0~1+");
}

TEST_F(WorldPairs, FollowAShapeThatIsSet) {
  world.set_pose(b, shift(2.05));
  EXPECT_EQ(told(world), "");
  const ShapeId wide = world.add_shape(sample_shape("box"), 0.1);
  EXPECT_EQ(world.margin(wide), 0.1);
  world.set_shape(a, wide);
  EXPECT_EQ(world.shape_id(a), wide);
  EXPECT_EQ(told(world), "0~1+");
  world.set_shape(a, box);
  world.remove_shape(wide);
  EXPECT_EQ(told(world), "0~1-");
}

TEST_F(WorldPairs, ComeLaterIfASearchIsCutShort) {
  const BodyId c = world.add_body(box, shift(0.5));
  world.add_body(box, shift(0.7));
  EXPECT_EQ(told(world), "0~1+ 0~2+ 0~3+ 1~2+ 1~3+ 2~3+");
  world.remove_body(c);
  world.add_body(box, shift(0.6));
  std::vector<Found> seen;
  const auto enough = [&](const CandidatePair& pair) {
    seen.push_back(found(pair));
    if (seen.size() == 3) throw std::runtime_error("enough");
  };
  // After 0~1=, 0~2-, 0~2'1+ the callback throws.
  EXPECT_THROW(world.find_candidates({.ended = enough}, enough), std::runtime_error);
  EXPECT_EQ(seen[1].what, What::ends);
  world.set_pose(b, shift(40));
  EXPECT_EQ(told(world), "0~1- 0~2'1= 0~3= 1~2- 1~3- 2~3- 2'1~3+");
}

// ---- Sleep ---------------------------------------------------------------

class WorldSleep : public WorldPairs {};

TEST_F(WorldSleep, HasNoEvents) {
  EXPECT_TRUE(world.is_awake(a));
  EXPECT_EQ(told(world), "0~1+");
  world.set_awake(a, false);
  EXPECT_FALSE(world.is_awake(a));
  EXPECT_EQ(told(world), "0~1=");
  world.set_awake(b, false);
  EXPECT_EQ(told(world), "");
  EXPECT_EQ(told(world), "");
  world.set_awake(a, true);
  EXPECT_EQ(told(world), "0~1=");
  world.set_awake(a, false);
  EXPECT_EQ(told(world), "");
  world.set_awake(a, true);
  world.set_pose(a, shift(-20));
  EXPECT_EQ(told(world), "0~1-");
  world.set_awake(a, false);
  world.set_awake(b, true);
  EXPECT_EQ(told(world), "");
}

TEST_F(WorldSleep, EndsForWhatIsRemoved) {
  world.add_half_space({Vector::UnitX(), 0});
  EXPECT_EQ(told(world), "0~1+ 0|0+ 1|0+");
  world.set_awake(a, false);
  world.set_awake(b, false);
  EXPECT_EQ(told(world), "");
  world.remove_body(a);
  EXPECT_EQ(told(world), "0~1- 0|0-");
  world.remove_half_space(HalfSpaceId{0});
  EXPECT_EQ(told(world), "1|0-");
  EXPECT_EQ(told(world), "");
}

TEST_F(WorldSleep, LetsEveryChangeBeSearchedOnce) {
  world.set_awake(a, false);
  world.set_awake(b, false);
  EXPECT_EQ(told(world), "0~1+");  // added, but not searched yet
  EXPECT_EQ(told(world), "");
  world.set_pose(a, shift(0.5));
  EXPECT_FALSE(world.is_awake(a));
  EXPECT_EQ(told(world), "0~1=");
  EXPECT_EQ(told(world), "");
  const BodyId wall = world.add_body(box, shift(10), {.kind = BodyKind::static_});
  EXPECT_FALSE(world.is_awake(wall));
  world.set_awake(wall, true);
  EXPECT_FALSE(world.is_awake(wall));
  EXPECT_EQ(told(world), "");
  world.set_pose(wall, shift(2));
  EXPECT_EQ(told(world), "0~2+ 1~2+");
  EXPECT_EQ(told(world), "");
  world.set_deformation(b, 0.5);
  EXPECT_EQ(told(world), "0~1= 1~2=");
  world.add_half_space({Vector::UnitX(), 0});
  EXPECT_EQ(told(world), "0|0+ 1|0+");
  EXPECT_EQ(told(world), "");
  world.set_filter(a, {2, 2});
  EXPECT_EQ(told(world), "0~1- 0~2- 0|0-");
  EXPECT_EQ(told(world), "");
}

TEST_F(WorldSleep, IsInterruptedByALargerMargin) {
  const auto told_at = [&](double margin) { return told(world, {.pair = {.margin = margin}}); };
  world.add_body(box, shift(3.3), {.kind = BodyKind::static_});
  world.add_half_space({Vector::UnitZ(), -1.2});
  EXPECT_EQ(told(world), "0~1+");
  world.set_awake(a, false);
  world.set_awake(b, false);
  EXPECT_EQ(told(world), "");
  EXPECT_EQ(told_at(0.5), "0~1= 0|0+ 1~2+ 1|0+");
  EXPECT_EQ(told_at(0.5), "");
  EXPECT_EQ(told(world), "");
  EXPECT_EQ(told_at(0.1), "0~1= 0|0- 1~2- 1|0-");
  EXPECT_EQ(told_at(0.1), "");
  EXPECT_EQ(told_at(0.05), "");
}

TEST_F(WorldSleep, IsTheCallersForKinematicBodies) {
  const BodyId lift = world.add_body(box, shift(0, 1), {.kind = BodyKind::kinematic});
  EXPECT_EQ(told(world), "0~1+ 0~2+ 1~2+");
  world.set_awake(a, false);
  world.set_awake(b, false);
  EXPECT_EQ(told(world), "0~2= 1~2=");
  world.set_awake(lift, false);
  EXPECT_EQ(told(world), "");
  world.set_motion(lift, {shift(0, 1), shift(0, 1.5)});
  EXPECT_EQ(told(world), "0~2= 1~2=");
  EXPECT_EQ(told(world), "");
  world.set_options(lift, {});
  EXPECT_FALSE(world.is_awake(lift));
  world.set_pose(lift, shift(0, 1.5));
  world.set_options(lift, {.kind = BodyKind::static_});
  world.set_options(lift, {});
  EXPECT_TRUE(world.is_awake(lift));
}

TEST(SleepingWorlds, CostNothingWhileNothingMoves) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  std::vector<BodyId> bodies;
  constexpr int n = 12;
  for (int i = 0; i < n * n * n; ++i) {
    bodies.push_back(world.add_body(box, shift(1.9 * (i % n), 1.9 * (i / n % n), 1.9 * (i / n / n))));
  }
  CandidateStatistics counts;
  candidates(world, {}, &counts);
  const std::int64_t all = counts.listed;
  EXPECT_GT(all, 10 * n * n * n);
  for (const BodyId body : bodies) world.set_awake(body, false);
  candidates(world, {}, &counts);
  EXPECT_EQ(counts.listed, 0);
  // One body wakes and leaves: the pairs with the 26 bodies around it are tested, then those at its new positions.
  const BodyId one = bodies[n * n * n / 2 + n * n / 2 + n / 2];
  world.set_awake(one, true);
  for (int step = 0; step < 5; ++step) {
    candidates(world, {}, &counts);
    EXPECT_GE(counts.listed, step == 0 ? 26 : 7);
    EXPECT_LE(counts.listed, 60);
    const Pose pose = world.motion(one).end;
    world.set_motion(one, {pose, shift(0.3, 0.2, 0.1) * pose});
  }
  world.set_awake(one, false);
  EXPECT_GT(candidates(world, {}, &counts).size(), 0u);  // its last motion has not been searched
  EXPECT_EQ(candidates(world, {}, &counts).size(), 0u);
  EXPECT_EQ(counts.listed, 0);
  for (const BodyId body : bodies) world.set_awake(body, true);
  candidates(world, {}, &counts);
  EXPECT_GT(counts.listed, all * 9 / 10);
}

}  // namespace
}  // namespace encage::test
