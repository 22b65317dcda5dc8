// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "oracles/meshes.h"
#include "tests/broadphase/world/twin.h"

#include <encage/world.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace encage::test {
namespace {

TEST(Worlds, FindWhatBruteForceFindsWhateverTheHistory) {
  std::int64_t total = 0, rejected = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const WorldOptions options_of_worlds[] = {{}, {.arcs = true}, {.pose_tolerance = 1e-4}, {true, 1e-4}};
    Twin twin(seed, options_of_worlds[seed % 4]);
    std::minstd_rand random(seed);
    for (int i = 0; i < 40; ++i) twin.add_body();
    for (int step = 0; step < 30 && !testing::Test::HasFailure(); ++step) {
      for (int i = 0; i < 12; ++i) twin.change(1 + static_cast<unsigned>(random() % 9));
      for (unsigned i = Twin::new_options; i < Twin::last; ++i) twin.change(i);
      if (step % 3 == 0) twin.change(Twin::remove);
      if (step % 4 == 0) twin.add_body();
      if (step == 20) twin.add_half_space();
      CandidateOptions options;
      if (step / 4 % 3 == 1) options.pair.margin = 0.01 * step;
      if (step / 4 % 3 == 2) options.pair.cages = CageUse::never;
      const std::vector<Found> expected = only_candidates(twin.brute_force(options.pair));
      CandidateStatistics counts, fresh_counts;
      ASSERT_EQ(candidates(twin.world, options, &counts), expected) << "seed " << seed << ", step " << step;
      World fresh = twin.fresh();
      ASSERT_EQ(candidates(fresh, options, &fresh_counts), expected);
      ASSERT_EQ(fresh_counts.asked, fresh_counts.overlapping);
      ASSERT_EQ(counts.overlapping, fresh_counts.overlapping);
      ASSERT_EQ(counts.separated, fresh_counts.separated);
      ASSERT_TRUE(std::is_sorted(expected.begin(), expected.end()));
      total += counts.candidates;
      rejected += counts.separated[1] + counts.separated[2];
    }
  }
  EXPECT_GT(total, 1000);
  EXPECT_GT(rejected, 100);
}

/// Removes the verdicts.
std::vector<Found> pairs(std::vector<Found> all) {
  for (Found& f : all) f = {f.a, f.half_space, f.b};
  return all;
}

// ---- Which bodies form pairs ------------------------------------------------

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
      {{.kind = BodyKind::static_}, {.kind = BodyKind::static_}, false},
      {{.group = 1, .kind = BodyKind::static_}, {.group = 1, .kind = BodyKind::static_}, false},
      {{.kind = BodyKind::static_}, {}, true},
      {{.kind = BodyKind::kinematic}, {}, true},
      {{.kind = BodyKind::kinematic}, {.kind = BodyKind::kinematic}, false},
      {{.group = 1, .kind = BodyKind::kinematic}, {.group = 1, .kind = BodyKind::static_}, false},
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

TEST(Worlds, HalfSpacesPairWithDynamicBodies) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));  // half edge 1
  const BodyId ball = world.add_body(shape, shift(0, 0, 5));
  world.add_body(shape, shift(50, 0, 0), {.kind = BodyKind::static_});
  world.add_body(shape, shift(70, 0, 0), {.kind = BodyKind::kinematic});
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

TEST(Worlds, ShapesHaveMarginsToo) {
  World world;
  const ShapeId soft = world.add_shape(sample_shape("box"), 0.25), hard = world.add_shape(sample_shape("box"));
  world.add_body(soft, shift(0));
  world.add_body(soft, shift(2.51));
  world.add_body(hard, shift(0, 2.24));
  world.add_body(hard, shift(0, 4.25));
  world.add_half_space({Vector::UnitZ(), -1.24}, {2, 1});
  EXPECT_EQ(pairs(candidates(world)), (std::vector<Found>{{0, false, 2}, {0, true, 0}, {1, true, 0}}));
}

TEST(Worlds, ScaleTheirBodies) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));  // half edge 1
  const BodyId a = world.add_body(shape, shift(0), {.scale = 0.25});
  const BodyId b = world.add_body(shape, shift(100), {.scale = 50});
  EXPECT_EQ(world.motion(b).scale, 50);
  world.add_half_space({Vector::UnitZ(), -0.6}, {2, 1});
  EXPECT_EQ(candidates(world).size(), 1u);
  const auto gap = [&](double x) {
    world.set_pose(a, shift(50 - 0.25 - x));
    return candidates(world).size() == 1;
  };
  EXPECT_TRUE(gap(1e-6));
  EXPECT_FALSE(gap(-1e-6));
  world.set_scale(a, 0.5);
  EXPECT_FALSE(gap(0.2));
  EXPECT_TRUE(gap(0.26));
  // A motion without a scale of its own, or with the body's, takes the body's scale.
  world.set_motion(a, {shift(0), shift(49.4)});
  EXPECT_EQ(world.motion(a).scale, 0.5);
  EXPECT_EQ(candidates(world).size(), 1u);
  world.set_motion(a, {shift(0), shift(49.6), 0.5});
  EXPECT_EQ(candidates(world).size(), 2u);
}

TEST(Worlds, RejectFarFromTheOriginAsNearIt) {
  shapes::Random random(8);
  const Vector far(1e7, -1e7, 1e7);
  // A generous bound of the rounding of frames at this distance (docs/guarantee.md, "Frames").
  const double tolerance = 1e-4;
  World here, there;
  for (const char* name : {"box", "star", "torus"}) {
    const ShapePtr shape = sample_shape(name);
    for (World* world : {&here, &there}) {
      const ShapeId id = world->add_shape(shape);
      for (int i = 0; i < 25; ++i) world->add_body(id, shift(0));
    }
  }
  std::size_t apart_all = 0;
  for (int step = 0; step < 10; ++step) {
    for (std::uint32_t i = 0; i < 75; ++i) {
      Motion m = Motion::resting(shift(0));
      // Multiples of 1/1024 are exact at the far position, too.
      const auto exact = [](double x) { return std::round(x * 1024) / 1024; };
      m.start.translation() = random.point(7).unaryExpr(exact);
      m.end.translation() = m.start.translation() + random.point(0.5).unaryExpr(exact);
      here.set_motion(static_cast<BodyId>(i), m);
      m.start.translation() += far;
      m.end.translation() += far;
      there.set_motion(static_cast<BodyId>(i), m);
    }
    CandidateStatistics counts;
    const std::vector<Found> near = pairs(candidates(here, {.pair = {.margin = 0.01}}));
    const std::vector<Found> distant = pairs(candidates(there, {.pair = {.margin = 0.01}}, &counts));
    const std::vector<Found> nearly = pairs(candidates(here, {.pair = {.margin = 0.01 + tolerance}}));
    EXPECT_TRUE(std::includes(distant.begin(), distant.end(), near.begin(), near.end()));
    EXPECT_TRUE(std::includes(nearly.begin(), nearly.end(), distant.begin(), distant.end()));
    EXPECT_GT(near.size(), 20u);
    apart_all += static_cast<std::size_t>(counts.separated[0] + counts.separated[1] + counts.separated[2]);
  }
  EXPECT_GT(apart_all, 50u);
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
  // A pair that was refused is tested once it is accepted.
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
    for_each_triangle_pair(*shape, world.motion(pair.a), *shape, world.motion(pair.b), 0.05, [&](TrianglePair t) {
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
      // The bodies move to and fro, so that the second round repeats the first.
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

// ---- Content and references ---------------------------------------------------

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
  // An exception of a visitor ends the search and leaves the world in order.
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
  EXPECT_EQ(other.shape_id(a), shape);
  EXPECT_EQ(candidates(other).size(), 1u);
}

}  // namespace
}  // namespace encage::test
