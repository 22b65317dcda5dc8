// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "tests/broadphase/world/twin.h"

namespace encage::test {
namespace {

/// All results of a step.
struct Shown {
  std::vector<Found> events;
  std::vector<std::int64_t> counts;
  std::vector<std::uint64_t> ids;
  std::vector<double> poses;
  friend bool operator==(const Shown&, const Shown&) = default;
};

/// Changes a world step by step, depending on random numbers alone. A copy continues in the same way.
class Script {
 public:
  explicit Script(unsigned seed) : random_(seed) {}

  void begin(World& world) {
    for (const char* name : {"box", "star"}) shapes_.push_back(world.add_shape(sample_shape(name)));
    for (int i = 0; i < 40; ++i) add(world);
    planes_.push_back(world.add_half_space({Vector::UnitZ(), 1}));
  }

  Shown step(World& world) {
    Shown shown;
    for (int i = 0; i < 12; ++i) change(world);
    CandidateStatistics s;
    shown.events = events(world, {.pair = {.margin = random_() % 4 == 0 ? 0.3 : 0.0}}, &s);
    shown.counts = {s.overlapping, s.separated[0], s.separated[1], s.separated[2], s.candidates, s.asked, s.listed};
    for (const BodyId body : bodies_) {
      shown.ids.push_back(static_cast<std::uint64_t>(body));
      const auto& m = world.motion(body).end.matrix();
      shown.poses.insert(shown.poses.end(), m.data(), m.data() + 16);
      shown.poses.push_back(world.deformation(body) + world.options(body).margin + (world.is_awake(body) ? 10 : 0));
    }
    return shown;
  }

 private:
  void add(World& world) {
    const BodyOptions options{.kind = random_() % 5 == 0 ? BodyKind::static_ : BodyKind::dynamic};
    bodies_.push_back(world.add_body(shapes_[random_() % 2], random_pose(), options));
  }
  void change(World& world) {
    const std::size_t i = random_() % bodies_.size();
    const BodyId body = bodies_[i];
    switch (random_() % 8) {
      case 0:
        world.remove_body(body);
        bodies_.erase(bodies_.begin() + static_cast<std::ptrdiff_t>(i));
        return;
      case 1: return add(world);
      case 2: return world.set_awake(body, !world.is_awake(body));
      case 3: return world.set_deformation(body, 0.01 * static_cast<double>(random_() % 30));
      case 4: return world.set_options(body, {.margin = 0.1 * static_cast<double>(random_() % 3)});
      case 5:
        world.remove_half_space(planes_.back());
        planes_.back() = world.add_half_space({Vector::UnitZ(), 0.1 * static_cast<double>(random_() % 30)});
        return;
      case 6: return world.set_shape(body, shapes_[random_() % 2]);
      default: return world.set_pose(body, random_pose());
    }
  }
  Pose random_pose() {
    const auto coordinate = [this] { return 0.01 * static_cast<double>(random_() % 600); };
    return shift(coordinate(), coordinate(), coordinate());
  }

  std::minstd_rand random_;
  std::vector<ShapeId> shapes_;
  std::vector<BodyId> bodies_;
  std::vector<HalfSpaceId> planes_;
};

TEST(WorldSnapshots, LetTheSameHappenAgain) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    World world;
    Script script(seed);
    script.begin(world);
    for (int i = 0; i < 7; ++i) script.step(world);
    const WorldSnapshot taken = world.snapshot();
    const Script from_here = script;
    std::vector<Shown> first;
    for (int i = 0; i < 25; ++i) first.push_back(script.step(world));
    EXPECT_FALSE(first.front() == first.back());
    // One snapshot is restored twice into the same world, and into one with other content.
    World other;
    Script(seed + 10).begin(other);
    for (World* again : {&world, &world, &other}) {
      again->restore(taken);
      Script replay = from_here;
      for (std::size_t i = 0; i < first.size(); ++i) {
        ASSERT_TRUE(replay.step(*again) == first[i]) << "seed " << seed << ", step " << i;
      }
    }
  }
}

TEST(WorldSnapshots, HoldEventsThatHaveNotComeYet) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  for (int i = 0; i < 4; ++i) world.add_body(box, shift(0.1 * i));
  candidates(world);
  world.remove_body(BodyId{1});
  const auto fail = [](const CandidatePair&) { throw std::runtime_error("enough"); };
  EXPECT_THROW(world.find_candidates({}, fail), std::runtime_error);
  const WorldSnapshot taken = world.snapshot();
  const std::vector<Found> expected = events(world);
  EXPECT_EQ(expected.size(), 3u + 2u);
  EXPECT_EQ(only_candidates(expected).size(), 3u);
  EXPECT_NE(events(world), expected);
  world.restore(taken);
  EXPECT_EQ(events(world), expected);
}

TEST(WorldSnapshots, ShareShapesAndOutliveTheWorld) {
  const ShapePtr shape = sample_shape("box");
  WorldSnapshot taken;
  {
    World world;
    const ShapeId box = world.add_shape(shape);
    for (int i = 0; i < 3; ++i) world.add_body(box, shift(0.1 * i));
    taken = world.snapshot();
  }
  EXPECT_EQ(shape.use_count(), 2);
  World other;
  other.restore(taken);
  EXPECT_EQ(other.shape(ShapeId{0}), shape);
  EXPECT_EQ(candidates(other).size(), 3u);
}

TEST(WorldSnapshots, AreRefusedWhereTheyCannotBe) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  for (int i = 0; i < 2; ++i) world.add_body(box, shift(0.1 * i));
  EXPECT_EQ(error_of([&] { world.restore({}); }), "the snapshot holds nothing");
  WorldSnapshot taken = world.snapshot(), moved = std::move(taken);
  int visits = 0;
  world.find_candidates({}, [&](const CandidatePair&) {
    ++visits;
    EXPECT_THROW(world.snapshot(), Error);
    EXPECT_THROW(world.restore(moved), Error);
  });
  EXPECT_EQ(visits, 1);
  world.restore(moved);
  EXPECT_EQ(candidates(world).size(), 1u);
}

TEST(WorldSnapshots, AllocateNothingOnceWarm) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  std::vector<BodyId> bodies;
  for (int i = 0; i < 50; ++i) bodies.push_back(world.add_body(box, shift(0.5 * i)));
  WorldSnapshot ring;
  std::size_t found = 0;
  const auto step = [&](int i) {
    if (i % 3 == 0) world.snapshot(ring);
    for (std::size_t b = 0; b < bodies.size(); b += 2)
      world.set_pose(bodies[b], shift(0.5 * i + static_cast<double>(b), 0.1 * i));
    world.set_awake(bodies[1], i % 2 == 0);
    world.find_candidates({}, [&](const CandidatePair&) { ++found; });
    if (i % 3 == 2) world.restore(ring);
  };
  for (int i = 0; i < 12; ++i) step(i);
  const long before = allocations;
  for (int i = 0; i < 12; ++i) step(i);
  EXPECT_EQ(allocations, before);
  EXPECT_GT(found, 100u);
}

}  // namespace
}  // namespace encage::test
