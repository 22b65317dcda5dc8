// SPDX-License-Identifier: GPL-3.0-or-later
// Overlapping boxes of bodies, in worlds that are difficult for a tree.
#include "oracles/count_allocations.h"
#include "oracles/meshes.h"
#include "tests/broadphase/world/thread_pool.h"
#include "tests/broadphase/world/twin.h"

#include <cmath>
#include <utility>

namespace encage::test {
namespace {

using BodyPair = std::pair<std::uint32_t, std::uint32_t>;

enum class Crowd { same_place, line, lattice, huge_and_tiny, jumping, distant, drifting, few_moving };

/// Cubes of several sizes, and their positions in each step.
class Cubes {
 public:
  Cubes(Crowd crowd, int count) : crowd_(crowd), motions_(static_cast<std::size_t>(count)) {
    for (const double size : {1.0, 1e-6, 1e4}) {
      CageHierarchy cube;
      cube.fine = shapes::cube(static_cast<double>(static_cast<float>(0.5 * size)));
      shapes_.push_back(make_shape(cube));
    }
  }

  std::size_t size() const { return motions_.size(); }
  const Motion& motion(std::size_t n) const { return motions_[n]; }
  const ShapePtr& shape(std::size_t n) const { return shapes_[shape_index(n)]; }
  const std::vector<ShapePtr>& shapes() const { return shapes_; }
  ShapeId shape_id(std::size_t n) const { return static_cast<ShapeId>(shape_index(n)); }
  double margin(std::size_t n) const { return n % 5 == 0 ? 0.3 : 0; }

  void step() {
    for (std::size_t n = 0; n < size(); ++n) {
      Motion& m = motions_[n];
      const Pose next = next_pose(n);
      m = {step_ == 0 || crowd_ == Crowd::jumping ? next : m.end, next};
    }
    ++step_;
  }
  void apply(World& world, const std::vector<BodyId>& bodies) const {
    for (std::size_t n = 0; n < size(); ++n) world.set_motion(bodies[n], motions_[n]);
  }

 private:
  std::size_t shape_index(std::size_t n) const { return crowd_ == Crowd::huge_and_tiny ? n % 41 == 0 ? 2 : n % 2 : 0; }
  double coordinate(double size) { return size * (static_cast<double>(random_() % 20'001) / 10'000 - 1); }
  Vector point(double size) {
    const double x = coordinate(size), y = coordinate(size);
    return {x, y, coordinate(size)};
  }
  Vector moved(std::size_t n, double by) { return motions_[n].end.translation() + point(by); }
  Vector target(std::size_t n) {
    const auto x = static_cast<double>(n);
    switch (crowd_) {
      case Crowd::same_place: return Vector(1, 2, 3);
      case Crowd::line: return Vector(x + 0.01 * step_, 0, 0);
      case Crowd::lattice: return Vector(static_cast<double>(n % 6), static_cast<double>(n / 6 % 6), step_ % 3);
      case Crowd::huge_and_tiny: return point(3);
      case Crowd::jumping: return point(8);
      case Crowd::distant: return step_ == 0 ? Vector(Vector(1e7, -1e7, 1e7) + point(5)) : moved(n, 0.5);
      case Crowd::drifting: return step_ == 0 ? point(4) : moved(n, 2);
      case Crowd::few_moving: return step_ == 0 ? point(5) : n % 10 == 0 ? moved(n, 1) : moved(n, 0);
    }
    return Vector::Zero();
  }
  Pose next_pose(std::size_t n) {
    Pose pose = Pose::Identity();
    pose.translation() = target(n);
    if (crowd_ == Crowd::drifting) {
      pose.linear() =
          Eigen::Quaterniond(2, coordinate(1), coordinate(1), coordinate(1)).normalized().toRotationMatrix();
    }
    return pose;
  }

  Crowd crowd_;
  int step_ = 0;
  std::minstd_rand random_{5};
  std::vector<Motion> motions_;
  std::vector<ShapePtr> shapes_;
};

const PairOptions boxes_only{.cages = CageUse::never, .fine = false};

struct CubeWorld {
  World world;
  std::vector<BodyId> bodies;
  CandidateOptions options;

  CubeWorld(const Cubes& cubes, const Executor& executor) : options{.pair = boxes_only, .executor = executor} {
    for (const ShapePtr& shape : cubes.shapes()) world.add_shape(shape);
    for (std::size_t n = 0; n < cubes.size(); ++n) {
      bodies.push_back(world.add_body(cubes.shape_id(n), cubes.motion(n).start, {.margin = cubes.margin(n)}));
    }
  }
  std::vector<BodyPair> pairs() {
    std::vector<BodyPair> found;
    world.find_candidates(options, [&](const CandidatePair& p) { found.emplace_back(index(p.a), index(p.b)); });
    return found;
  }
};

std::vector<BodyPair> brute_force(const Cubes& cubes, double margin) {
  std::vector<BodyPair> found;
  PairOptions options = boxes_only;
  for (std::uint32_t a = 0; a < cubes.size(); ++a) {
    for (std::uint32_t b = a + 1; b < cubes.size(); ++b) {
      options.margin = margin + cubes.margin(a) + cubes.margin(b);
      if (!separated(*cubes.shape(a), cubes.motion(a), *cubes.shape(b), cubes.motion(b), options).separated) {
        found.emplace_back(a, b);
      }
    }
  }
  return found;
}

TEST(WorldBoxes, AreFoundInCrowdsThatAreHardOnATree) {
  ThreadPool pool(3);
  for (const Crowd crowd : {Crowd::same_place, Crowd::line, Crowd::lattice, Crowd::huge_and_tiny, Crowd::jumping,
                            Crowd::distant, Crowd::drifting, Crowd::few_moving}) {
    SCOPED_TRACE(static_cast<int>(crowd));
    Cubes cubes(crowd, 170);
    cubes.step();
    CubeWorld alone(cubes, {}), shared(cubes, pool.executor());
    std::size_t total = 0;
    for (int step = 0; step < 12; ++step) {
      const double margin = step % 4 == 3 ? 0.25 : 0;
      for (CubeWorld* world : {&alone, &shared}) {
        world->options.pair.margin = margin;
        cubes.apply(world->world, world->bodies);
        const std::vector<BodyPair> found = world->pairs(), expected = brute_force(cubes, margin);
        ASSERT_EQ(found, expected) << "step " << step;
        total += found.size();
      }
      cubes.step();
    }
    EXPECT_GT(total, 1000u);
  }
}

TEST(WorldBoxes, DoNotAllocateOnceWarm) {
  Cubes cubes(Crowd::lattice, 150);
  cubes.step();
  CubeWorld world(cubes, {});
  const auto walk = [&] {
    for (int step = 0; step < 9; ++step) {
      cubes.apply(world.world, world.bodies);
      world.world.find_candidates(world.options, [](const CandidatePair&) {});
      cubes.step();
    }
  };
  walk();
  const long before = allocations;
  walk();
  EXPECT_EQ(allocations, before);
}

}  // namespace
}  // namespace encage::test
