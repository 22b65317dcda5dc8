// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/count_allocations.h"
#include "tests/broadphase/world_twin.h"

#include <encage/world.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <vector>

namespace encage::test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Worlds, FindWhatBruteForceFindsWhateverTheHistory) {
  std::int64_t total = 0, rejected = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    Twin twin(seed);
    std::minstd_rand random(seed);
    for (int i = 0; i < 40; ++i) twin.add_body();
    for (int step = 0; step < 30 && !testing::Test::HasFailure(); ++step) {
      for (int i = 0; i < 12; ++i) twin.change(1 + static_cast<unsigned>(random() % 9));
      if (step % 3 == 0) twin.change(0);
      if (step % 4 == 0) twin.add_body();
      if (step == 20) twin.add_half_space();
      CandidateOptions options;
      if (step / 4 % 3 == 1) options.pair.margin = 0.01 * step;
      if (step / 4 % 3 == 2) options.pair.cages = CageUse::never;
      const std::vector<Found> expected = twin.brute_force(options.pair);
      CandidateStatistics counts, fresh_counts;
      ASSERT_EQ(candidates(twin.world, options, &counts), expected) << "seed " << seed << ", step " << step;
      World fresh = twin.fresh();
      ASSERT_EQ(candidates(fresh, options, &fresh_counts), expected);
      ASSERT_EQ(counts.overlapping, fresh_counts.overlapping);
      ASSERT_EQ(counts.separated, fresh_counts.separated);
      ASSERT_EQ(fresh_counts.asked, fresh_counts.overlapping);
      ASSERT_TRUE(std::is_sorted(expected.begin(), expected.end()));
      total += counts.candidates;
      rejected += counts.separated[1] + counts.separated[2];
    }
  }
  EXPECT_GT(total, 1000);
  EXPECT_GT(rejected, 100);
}

// ---- What pairs ----------------------------------------------------------

TEST(Worlds, FiltersAndGroupsDecideAsDocumented) {
  struct Case {
    BodyOptions a, b;
    bool pair;
  };
  const Filter one{1, ~0u}, two{2, ~0u}, two_hates_one{2, ~1u}, none{0, ~0u};
  const std::vector<Case> cases = {
      {{.filter = one}, {.filter = two}, true},
      {{.filter = one}, {.filter = two_hates_one}, false},
      {{.filter = two_hates_one}, {.filter = two}, true},
      {{.filter = none}, {.filter = one}, false},
      {{.filter = one, .group = 3}, {.filter = two_hates_one, .group = 3}, true},
      {{.filter = one, .group = 3}, {.filter = two_hates_one, .group = 4}, false},
      {{.filter = one, .group = -3}, {.filter = one, .group = -3}, false},
      {{.filter = one, .group = -3}, {.filter = one, .group = -4}, true},
      {{.is_static = true}, {.is_static = true}, false},
      {{.group = 1, .is_static = true}, {.group = 1, .is_static = true}, false},
      {{.is_static = true}, {}, true},
  };
  for (const Case& c : cases) {
    for (const bool swapped : {false, true}) {
      World world;
      const ShapeId shape = world.add_shape(sample_shape("box"));
      world.add_body(shape, Pose::Identity(), swapped ? c.b : c.a);
      world.add_body(shape, shift(0.5), swapped ? c.a : c.b);
      EXPECT_EQ(candidates(world).size(), c.pair ? 1u : 0u) << "case " << &c - cases.data();
    }
  }
}

TEST(Worlds, HalfSpacesPairWithWhatMoves) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));  // half edge 1
  const BodyId ball = world.add_body(shape, shift(0, 0, 5));
  world.add_body(shape, shift(50, 0, 0), {.is_static = true});
  world.add_body(shape, shift(90, 0, 0.5), {.filter = {2, ~2u}});
  const HalfSpaceId floor = world.add_half_space({Vector::UnitZ(), 0}, {2, ~0u});
  world.add_half_space({Vector::UnitZ(), -10});
  EXPECT_TRUE(candidates(world).empty());
  world.set_motion(ball, {shift(0, 0, 5), shift(0, 0, 0.9)});
  int calls = 0;
  world.find_candidates({}, [&](const CandidatePair& pair) {
    ++calls;
    EXPECT_EQ(pair.a, ball);
    EXPECT_EQ(pair.b, BodyId::none);
    EXPECT_EQ(pair.half_space, floor);
    EXPECT_TRUE(pair.triangles.empty());
  });
  EXPECT_EQ(calls, 1);
  world.set_motion(ball, {shift(0, 0, 5), shift(0, 0, 1.2)});
  EXPECT_TRUE(candidates(world).empty());
  EXPECT_EQ(candidates(world, {.pair = {.margin = 0.3}}).size(), 1u);
}

TEST(Worlds, MarginsAddUp) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));
  world.add_body(shape, shift(0), {.margin = 0.2});
  world.add_body(shape, shift(3), {.margin = 0.3});
  EXPECT_EQ(candidates(world).size(), 0u);
  EXPECT_EQ(candidates(world, {.pair = {.margin = 0.499}}).size(), 0u);
  EXPECT_EQ(candidates(world, {.pair = {.margin = 0.501}}).size(), 1u);
  EXPECT_EQ(candidates(world, {.pair = {.margin = 0.499}}).size(), 0u);
}

TEST(Worlds, ThePredicateSeesEveryOverlapAndDropsWhatItRefuses) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));
  for (int i = 0; i < 6; ++i) world.add_body(shape, shift(0.1 * i));
  world.add_body(shape, shift(100));
  world.add_half_space({Vector::UnitX(), -0.95});
  std::vector<Found> seen;
  CandidateOptions options;
  options.accept = [&](const CandidatePair& pair) {
    seen.push_back(found(pair));
    return pair.a != BodyId{2};
  };
  CandidateStatistics counts;
  const std::vector<Found> kept = candidates(world, options, &counts);
  EXPECT_EQ(counts.overlapping, 15 + 1);
  EXPECT_EQ(counts.refused, 3);
  EXPECT_EQ(seen.size(), 16u);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_TRUE(std::none_of(kept.begin(), kept.end(), [](const Found& f) { return f.a == 2; }));
  // What was refused is asked once it is wanted.
  EXPECT_EQ(candidates(world, {}, &counts).size(), 16u);
  EXPECT_EQ(counts.asked, 3);
}

TEST(Worlds, TrianglesAreThoseOfForEachCandidate) {
  World world;
  const ShapePtr shape = sample_shape("star"), caged = make_shape(without_fine(sample_shapes(0)[1]).hierarchy);
  const ShapeId star = world.add_shape(shape), cage = world.add_shape(caged);
  const std::vector<Motion> motions = {
      Motion::resting(shift(0)), {shift(0.9), shift(1.2, 0.3)}, Motion::resting(shift(2.4))};
  for (const Motion& motion : motions) world.set_motion(world.add_body(star, motion.start), motion);
  world.add_body(cage, shift(0.5));
  int pairs = 0;
  world.find_candidates({.pair = {.margin = 0.05}, .triangles = true}, [&](const CandidatePair& pair) {
    std::vector<std::pair<int, int>> expected, given;
    for (const TrianglePair t : pair.triangles) given.emplace_back(t.a, t.b);
    if (pair.b == BodyId{3}) {
      EXPECT_TRUE(given.empty());
      return;
    }
    ++pairs;
    for_each_candidate(*shape, world.motion(pair.a), *shape, world.motion(pair.b), 0.05, [&](TrianglePair t) {
      expected.emplace_back(t.a, t.b);
      return true;
    });
    EXPECT_EQ(given, expected);
    EXPECT_FALSE(given.empty());
  });
  EXPECT_GE(pairs, 1);
  world.find_candidates({}, [&](const CandidatePair& pair) { EXPECT_TRUE(pair.triangles.empty()); });
}

// ---- Cost ----------------------------------------------------------------

TEST(Worlds, OnlyPairsOfChangedBodiesAreAskedAgain) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));
  for (int i = 0; i < 10; ++i) world.add_body(shape, shift(1.5 * i));  // a chain of 9 overlaps
  world.add_half_space({Vector::UnitZ(), 0});
  CandidateStatistics counts;
  candidates(world, {}, &counts);
  EXPECT_EQ(counts.asked, 9 + 10);
  candidates(world, {}, &counts);
  EXPECT_EQ(counts.asked, 0);
  EXPECT_EQ(counts.candidates, 19);
  world.set_pose(BodyId{0}, shift(0));  // no change
  candidates(world, {}, &counts);
  EXPECT_EQ(counts.asked, 0);
  world.set_motion(BodyId{4}, {shift(6), shift(6.1)});
  candidates(world, {}, &counts);
  EXPECT_EQ(counts.asked, 3);
  world.remove_body(BodyId{0});
  candidates(world, {}, &counts);
  EXPECT_EQ(counts.asked, 0);
  EXPECT_EQ(counts.candidates, 17);
  candidates(world, {.pair = {.fine = false}}, &counts);
  EXPECT_EQ(counts.asked, 17);
}

TEST(Worlds, SearchesDoNotAllocateOnceWarm) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("star"));
  std::minstd_rand random(3);
  const auto coordinate = [&] { return 0.01 * static_cast<double>(random() % 600); };
  for (int i = 0; i < 60; ++i) world.add_body(shape, shift(coordinate(), coordinate(), coordinate()));
  world.add_half_space({Vector::UnitZ(), 1});
  const CandidateOptions options{.triangles = true};
  std::size_t triangles = 0;
  const auto step = [&](int from) {
    for (std::uint32_t i = 0; i < 60; ++i) {
      const auto body = static_cast<BodyId>(i);
      const Pose start = world.motion(body).end;
      // To and fro, so that the second round repeats the first.
      world.set_motion(body, {start, shift(0.2 * (from % 2 == 0 ? 1 : -1), 0.1 * (from % 4 < 2 ? 1 : -1)) * start});
    }
    world.find_candidates(options, [&](const CandidatePair& pair) { triangles += pair.triangles.size(); });
  };
  for (int i = 0; i < 40; ++i) step(i);
  ASSERT_GT(triangles, 100u);
  const long before = allocations;
  for (int i = 0; i < 40; ++i) step(i);
  EXPECT_EQ(allocations, before);
}

// ---- Bad input -----------------------------------------------------------

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Worlds, RefuseBadInputAndStayAsTheyAre) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));
  const BodyId body = world.add_body(shape, shift(0));
  const BodyId ground = world.add_body(shape, shift(1), {.is_static = true});
  const BodyId removed = world.add_body(shape, shift(1, 1));
  world.remove_body(removed);
  world.add_half_space({Vector::UnitZ(), 0});
  const Motion before = {shift(0), shift(0.25)};
  world.set_motion(body, before);
  const std::vector<Found> expected = candidates(world);
  ASSERT_EQ(expected.size(), 2u);

  Pose nan = shift(0), infinite = shift(infinity), stretched = shift(0), distant = shift(1e160), turned = shift(0);
  nan.linear()(1, 2) = std::nan("");
  stretched.linear()(1, 1) = 1 + 1e-8;
  turned.linear() = Eigen::AngleAxisd(std::acos(-1.0), Vector(1, 2, 3).normalized()).toRotationMatrix();
  const auto no_visit = [](const CandidatePair&) { FAIL(); };
  struct Case {
    std::function<void()> call;
    std::string says;
  };
  const std::vector<Case> cases = {
      {[&] { world.add_shape(nullptr); }, "shape 1: null"},
      {[&] { world.add_body(ShapeId{7}, shift(0)); }, "body 3: there is no shape 7"},
      {[&] { world.add_body(shape, nan); }, "body 3: the pose is not finite"},
      {[&] { world.add_body(shape, infinite); }, "body 3: the pose is not finite"},
      {[&] { world.add_body(shape, distant); }, "body 3: the pose is farther than 1e150 away"},
      {[&] { world.add_body(shape, stretched); }, "body 3: the pose is farther than 1e-9 from rigid"},
      {[&] { world.add_body(shape, shift(0), {.margin = -1}); }, "body 3: the margin is negative or not a number"},
      {[&] { world.add_body(shape, shift(0), {.margin = std::nan("")}); },
       "body 3: the margin is negative or not a number"},
      {[&] { world.add_body(shape, shift(0), {.margin = infinity}); }, "body 3: the margin is larger than 1e150"},
      {[&] { world.set_pose(body, nan); }, "body 0: the pose is not finite"},
      {[&] { world.set_pose(body, stretched); }, "body 0: the pose is farther than 1e-9 from rigid"},
      {[&] {
         world.set_motion(body, {shift(0), nan});
       },
       "body 0: the end pose is not finite"},
      {[&] {
         world.set_motion(body, {infinite, shift(0)});
       },
       "body 0: the start pose is not finite"},
      {[&] {
         world.set_motion(body, {shift(0), distant});
       },
       "body 0: the end pose is farther than 1e150 away"},
      {[&] {
         world.set_motion(body, {stretched, shift(0)});
       },
       "body 0: the start pose is farther than 1e-9 from rigid"},
      {[&] {
         world.set_motion(body, {shift(0), turned});
       },
       "body 0: the rotation within the step reaches 180 degrees"},
      {[&] {
         world.set_motion(ground, {shift(0), shift(1)});
       },
       "body 1: a static body cannot move within a step"},
      {[&] { world.set_pose(removed, shift(0)); }, "body 2: was removed"},
      {[&] { world.set_motion(BodyId{9}, before); }, "body 9: there is no such body"},
      {[&] { world.set_motion(BodyId::none, before); }, "body 4294967295: there is no such body"},
      {[&] { world.remove_body(removed); }, "body 2: was removed"},
      {[&] { world.remove_body(BodyId{9}); }, "body 9: there is no such body"},
      {[&] { (void)world.motion(removed); }, "body 2: was removed"},
      {[&] { (void)world.options(BodyId{3}); }, "body 3: there is no such body"},
      {[&] { (void)world.shape(BodyId{3}); }, "body 3: there is no such body"},
      {[&] { (void)world.half_space(HalfSpaceId{1}); }, "half-space 1: there is no such half-space"},
      {[&] {
         world.add_half_space({Vector::Ones(), 0});
       },
       "half-space 1: the normal's length is not 1"},
      {[&] {
         world.add_half_space({Vector::UnitX() * (1 + 2e-9), 0});
       },
       "half-space 1: the normal's length is not 1"},
      {[&] {
         world.add_half_space({Vector(0, 0, infinity), 0});
       },
       "half-space 1: the normal is not finite"},
      {[&] {
         world.add_half_space({Vector::UnitX(), std::nan("")});
       },
       "half-space 1: the offset is not finite"},
      {[&] { world.find_candidates({.pair = {.margin = -0.5}}, no_visit); },
       "candidate options: the margin is negative or not finite"},
      {[&] { world.find_candidates({.pair = {.margin = std::nan("")}}, no_visit); },
       "candidate options: the margin is negative or not finite"},
      {[&] { world.find_candidates({.pair = {.margin = infinity}}, no_visit); },
       "candidate options: the margin is negative or not finite"},
  };
  for (const Case& c : cases) {
    EXPECT_EQ(error_of(c.call), c.says);
    EXPECT_EQ(world.body_count(), 2);
    EXPECT_EQ(world.shape_count(), 1);
    EXPECT_EQ(world.half_space_count(), 1);
    EXPECT_EQ(world.motion(body).end.matrix(), before.end.matrix());
    EXPECT_EQ(candidates(world), expected) << c.says;
  }
  EXPECT_EQ(world.add_body(shape, shift(0)), BodyId{3});
}

TEST(Worlds, MayBeReadButNotChangedWhileTheyVisit) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));
  const BodyId a = world.add_body(shape, shift(0));
  world.add_body(shape, shift(1));
  int visits = 0;
  world.find_candidates({}, [&](const CandidatePair& pair) {
    ++visits;
    const std::string locked = "the world cannot be changed while it visits candidates";
    EXPECT_EQ(world.motion(pair.b).end.translation().x(), 1);
    EXPECT_EQ(error_of([&] { world.remove_body(a); }), locked);
    EXPECT_EQ(error_of([&] { world.set_pose(a, shift(2)); }), locked);
    EXPECT_EQ(error_of([&] { world.add_body(shape, shift(2)); }), locked);
    EXPECT_EQ(error_of([&] { world.add_half_space({}); }), locked);
    EXPECT_EQ(error_of([&] { world.add_shape(sample_shape("box")); }), locked);
    EXPECT_EQ(error_of([&] { candidates(world); }), locked);
  });
  EXPECT_EQ(visits, 1);
  // What a visitor throws ends the search and leaves the world in order.
  EXPECT_THROW(world.find_candidates({}, [](const CandidatePair&) { throw std::runtime_error("enough"); }),
               std::runtime_error);
  EXPECT_EQ(candidates(world).size(), 1u);
  world.set_pose(a, shift(9));
  EXPECT_EQ(candidates(world).size(), 0u);
}

TEST(Worlds, CanBeMovedAndTellWhatTheyHold) {
  World world;
  const ShapePtr box = sample_shape("box");
  const ShapeId shape = world.add_shape(box);
  const BodyId a = world.add_body(shape, shift(0), {.group = 5});
  const BodyId b = world.add_body(shape, shift(1));
  world.add_half_space({Vector::UnitY(), 0.25});
  World other = std::move(world);
  EXPECT_TRUE(other.contains(b));
  other.remove_body(b);
  EXPECT_FALSE(other.contains(b));
  EXPECT_FALSE(other.contains(BodyId::none));
  EXPECT_EQ(other.body_count(), 1);
  EXPECT_EQ(other.shape(a), box);
  EXPECT_EQ(other.options(a).group, 5);
  EXPECT_EQ(other.half_space(HalfSpaceId{0}).offset, 0.25);
  EXPECT_EQ(candidates(other).size(), 1u);
}

}  // namespace
}  // namespace encage::test
