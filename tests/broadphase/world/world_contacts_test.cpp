// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "oracles/sampled.h"
#include "tests/broadphase/world/thread_pool.h"
#include "tests/broadphase/world/twin.h"

#include <encage/world_contacts.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

namespace encage::test {
namespace {

/// What a visit or an end tells.
struct Seen {
  BodyId a, b;
  HalfSpaceId half_space;
  PairEvent event;
  std::vector<ManifoldPoint> points;
  std::optional<Contact> first;
};

bool same(const ManifoldPoint& x, const ManifoldPoint& y) {
  return x.point_a == y.point_a && x.point_b == y.point_b && x.normal == y.normal && x.separation == y.separation &&
         x.feature == y.feature && x.patch == y.patch;
}
bool same(const Seen& x, const Seen& y) {
  const auto time = [](const Seen& seen) { return seen.first ? seen.first->time : -1; };
  return x.a == y.a && x.b == y.b && x.half_space == y.half_space && x.event == y.event && time(x) == time(y) &&
         std::equal(x.points.begin(), x.points.end(), y.points.begin(), y.points.end(),
                    [](const auto& p, const auto& q) { return same(p, q); });
}
void expect_same(const std::vector<Seen>& found, const std::vector<Seen>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_TRUE(same(found[i], expected[i])) << "pair " << i;
}

std::vector<Seen> find(WorldContacts& contacts, World& world, WorldContactOptions options = {},
                       WorldContactStatistics* statistics = nullptr) {
  std::vector<Seen> all;
  const auto add = [&](const ContactPair& pair) {
    all.push_back({pair.a, pair.b, pair.half_space, pair.event, {pair.points.begin(), pair.points.end()}, pair.first});
  };
  options.ended = add;
  const WorldContactStatistics counts = contacts.find(world, options, add);
  if (statistics != nullptr) *statistics = counts;
  return all;
}

/// Every pair of bodies by itself.
class Twin {
 public:
  std::vector<Seen> find(const World& world, const std::vector<BodyId>& bodies, const std::vector<HalfSpaceId>& planes,
                         const WorldContactOptions& options) {
    const double search_margin = std::max(options.margin, options.first_contacts ? options.first_margin : 0);
    std::vector<Seen> all;
    for (const BodyId a : bodies) {
      const bool dynamic = world.options(a).kind == BodyKind::dynamic;
      const auto margin = [&](BodyId body) {
        return world.options(body).margin + world.margin(world.shape_id(body)) + world.deformation(body) +
               correction_margin(*world.shape(body), world.pose_deviation(body), world.options(body).scale);
      };
      const auto arc = [&](BodyId body) {
        return world.options().arcs ? arc_margin(*world.shape(body), world.motion(body)) : 0;
      };
      for (const BodyId b : bodies) {
        if (index(b) <= index(a) || (!dynamic && world.options(b).kind != BodyKind::dynamic)) continue;
        visit(
            all, {a, b, HalfSpaceId::none, {}, {}, {}}, options, margin(a) + margin(b), arc(a) + arc(b),
            separated(*world.shape(a), world.motion(a), *world.shape(b), world.motion(b),
                      {.margin = search_margin + margin(a) + margin(b) + arc(a) + arc(b), .fine = false})
                .separated,
            [&](const ManifoldOptions& manifold, ManifoldCache& cache, std::span<ManifoldPoint> to) {
              return contact_manifold(*world.shape(a), world.motion(a), *world.shape(b), world.motion(b), manifold,
                                      cache, to);
            },
            [&](const ContactOptions& first) {
              return first_contact(*world.shape(a), world.motion(a), *world.shape(b), world.motion(b), first);
            });
      }
      for (const HalfSpaceId plane : planes) {
        if (!dynamic) continue;
        visit(
            all, {a, BodyId::none, plane, {}, {}, {}}, options, margin(a), arc(a),
            separated(*world.shape(a), world.motion(a), world.half_space(plane), search_margin + margin(a) + arc(a))
                .separated,
            [&](const ManifoldOptions& manifold, ManifoldCache& cache, std::span<ManifoldPoint> to) {
              return contact_manifold(*world.shape(a), world.motion(a), world.half_space(plane), manifold, cache, to);
            },
            [&](const ContactOptions& first) {
              return first_contact(*world.shape(a), world.motion(a), world.half_space(plane), first);
            });
      }
    }
    return all;
  }

 private:
  struct Memory {
    ManifoldCache cache;
    bool touching = false;
  };

  template <class Manifold, class First>
  void visit(std::vector<Seen>& all, Seen seen, const WorldContactOptions& options, double margin, double arc,
             bool apart, const Manifold& manifold, const First& first) {
    Memory& memory = memories_[{seen.a, seen.b, seen.half_space}];
    std::array<ManifoldPoint, 64> found;
    const ManifoldOptions asked{.margin = options.margin + margin,
                                .most_points = options.most_points,
                                .most_per_patch = options.most_per_patch};
    if (options.manifolds) {
      const int count = manifold(asked, memory.cache, found);
      seen.points.assign(found.begin(), found.begin() + count);
    }
    if (options.first_contacts) seen.first = first(ContactOptions{.margin = options.first_margin + margin, .arc = arc});
    if (apart) {
      // A pair that is no candidate is forgotten. What is proven to stay apart may seem to approach.
      for (const ManifoldPoint& point : seen.points) EXPECT_GT(point.separation, asked.margin);
      EXPECT_FALSE(seen.first);
      seen.points.clear();
      memory.cache.clear();
    }
    const bool touches = !seen.points.empty() || seen.first;
    seen.event = !touches ? PairEvent::end : memory.touching ? PairEvent::persist : PairEvent::begin;
    if (touches || memory.touching) all.push_back(std::move(seen));
    memory.touching = touches;
  }

  std::map<std::tuple<BodyId, BodyId, HalfSpaceId>, Memory> memories_;
};

/// Bodies in a small room that move at random in each step.
class Crowd {
 public:
  explicit Crowd(std::uint32_t seed, const WorldOptions& options = {})
      : world(options), random_(seed), all_(sample_bodies()) {
    std::erase_if(all_, [](const Body& body) { return !body.has_fine(); });
    for (int i = 0; i < 14; ++i) {
      const Body& body = all_[static_cast<std::size_t>(random_.integer(static_cast<int>(all_.size())))];
      const ShapeId shape = world.add_shape(body.shape, i % 5 == 0 ? 0.01 : 0);
      BodyOptions body_options{.margin = i % 4 == 0 ? 0.02 : 0, .scale = i % 3 == 0 ? 0.5 : 1};
      if (i % 6 == 1) body_options.kind = BodyKind::kinematic;
      if (i % 6 == 2) body_options.kind = BodyKind::static_;
      bodies.push_back(world.add_body(shape, random_pose(random_, 1.6), body_options));
    }
    planes = {world.add_half_space({Vector::UnitZ(), -1.5}), world.add_half_space({-Vector::UnitX(), -1.8})};
  }

  void step() {
    for (const BodyId body : bodies) {
      if (world.options(body).kind == BodyKind::static_ || random_(0, 1) < 0.2) continue;
      Motion motion = world.motion(body);
      motion.start = motion.end;
      motion.end.translation() += random_(0, 0.1) * random_direction(random_);
      motion.end.linear() =
          motion.start.linear() * Eigen::AngleAxisd(random_(0, 0.2), random_direction(random_)).toRotationMatrix();
      motion.end.linear() = Eigen::Quaterniond(motion.end.linear()).normalized().toRotationMatrix();
      // As an engine has it.
      if (world.options().pose_tolerance > 0) motion.end.matrix() = motion.end.matrix().cast<float>().cast<double>();
      world.set_motion(body, motion);
    }
  }

  World world;
  std::vector<BodyId> bodies;
  std::vector<HalfSpaceId> planes;

 private:
  shapes::Random random_;
  std::vector<Body> all_;
};

TEST(WorldContacts, AreThoseOfAllPairs) {
  int begun = 0, ended = 0, persisted = 0, points = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    Crowd crowd(seed, {.arcs = seed % 4 == 0, .pose_tolerance = seed % 2 == 1 ? 1e-4 : 0});
    WorldContacts contacts;
    Twin twin;
    const WorldContactOptions options{.margin = 0.03, .first_contacts = seed % 2 == 0, .first_margin = 0.01};
    for (int step = 0; step < 12; ++step) {
      crowd.step();
      WorldContactStatistics statistics;
      const std::vector<Seen> found = find(contacts, crowd.world, options, &statistics);
      expect_same(found, twin.find(crowd.world, crowd.bodies, crowd.planes, options));
      std::int64_t pairs = 0, all_points = 0;
      for (const Seen& seen : found) {
        begun += seen.event == PairEvent::begin;
        ended += seen.event == PairEvent::end;
        persisted += seen.event == PairEvent::persist;
        pairs += seen.event != PairEvent::end;
        all_points += static_cast<std::int64_t>(seen.points.size());
      }
      EXPECT_EQ(statistics.pairs, pairs);
      EXPECT_EQ(statistics.points, all_points);
      points += static_cast<int>(all_points);
    }
  }
  EXPECT_GT(begun, 100);
  EXPECT_GT(ended, 20);
  EXPECT_GT(persisted, 300);
  EXPECT_GT(points, 2000);
}

TEST(WorldContacts, DoNotDependOnThreads) {
  Crowd crowd(5), other(5);
  WorldContacts one, many;
  ThreadPool pool(4);
  for (int step = 0; step < 8; ++step) {
    crowd.step();
    other.step();
    const WorldContactOptions options{.margin = 0.03, .first_contacts = true};
    WorldContactOptions shared = options;
    shared.executor = pool.executor();
    expect_same(find(many, other.world, shared), find(one, crowd.world, options));
  }
}

TEST(WorldContacts, ACopyRemembersTheSame) {
  Crowd crowd(6);
  WorldContacts contacts;
  for (int step = 0; step < 4; ++step) {
    crowd.step();
    find(contacts, crowd.world, {.margin = 0.03});
  }
  WorldContacts copy = contacts;
  const WorldSnapshot snapshot = crowd.world.snapshot();
  crowd.world.remove_body(crowd.bodies.back());
  const std::vector<Seen> once = find(contacts, crowd.world, {.margin = 0.03});
  crowd.world.restore(snapshot);
  crowd.world.remove_body(crowd.bodies.back());
  expect_same(find(copy, crowd.world, {.margin = 0.03}), once);
  EXPECT_FALSE(once.empty());
}

/// Two cubes one on the other, on a plane.
struct Stack {
  World world;
  ShapeId cube = world.add_shape(make_shape(shapes::cube(0.5)));
  BodyId lower = world.add_body(cube, at(0.5)), upper = world.add_body(cube, at(1.5));
  HalfSpaceId ground = world.add_half_space({Vector::UnitZ(), 0});
  WorldContacts contacts;

  static Pose at(double z) { return Pose(Eigen::Translation3d(0, 0, z)); }
};

TEST(WorldContacts, OfAStack) {
  Stack stack;
  const std::vector<Seen> found = find(stack.contacts, stack.world, {.margin = 0.01});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].a, stack.lower);
  EXPECT_EQ(found[0].b, stack.upper);
  EXPECT_EQ(found[1].a, stack.lower);
  EXPECT_EQ(found[1].half_space, stack.ground);
  for (const Seen& seen : found) {
    EXPECT_EQ(seen.event, PairEvent::begin);
    ASSERT_EQ(seen.points.size(), 4U);
    for (const ManifoldPoint& p : seen.points) EXPECT_NEAR(p.separation, 0, 1e-12);
  }
  EXPECT_EQ(found[0].points[0].normal, Vector(-Vector::UnitZ()));
  EXPECT_EQ(found[1].points[0].normal, Vector(Vector::UnitZ()));
}

TEST(WorldContacts, EndWithTheBodyAndBeginAnewForTheNextOfItsIndex) {
  Stack stack;
  find(stack.contacts, stack.world, {.margin = 0.01});
  stack.world.remove_body(stack.upper);
  const BodyId next = stack.world.add_body(stack.cube, Stack::at(1.5));
  ASSERT_EQ(index(next), index(stack.upper));
  const std::vector<Seen> found = find(stack.contacts, stack.world, {.margin = 0.01});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].b, stack.upper);
  EXPECT_EQ(found[0].event, PairEvent::end);
  EXPECT_EQ(found[1].b, next);
  EXPECT_EQ(found[1].event, PairEvent::begin);
  EXPECT_EQ(found[2].event, PairEvent::persist);
}

TEST(WorldContacts, WhoeverVisitsMayChangeTheWorldAndThrow) {
  Stack stack;
  int visits = 0;
  EXPECT_THROW(stack.contacts.find(stack.world, {.margin = 0.01},
                                   [&](const ContactPair&) {
                                     ++visits;
                                     throw std::runtime_error("enough");
                                   }),
               std::runtime_error);
  EXPECT_EQ(visits, 1);
  std::vector<PairEvent> events;
  stack.contacts.find(stack.world, {.margin = 0.01}, [&](const ContactPair& pair) {
    events.push_back(pair.event);
    if (pair.half_space != HalfSpaceId::none) stack.world.remove_body(stack.upper);
  });
  EXPECT_EQ(events, (std::vector{PairEvent::persist, PairEvent::begin}));
  EXPECT_EQ(stack.world.body_count(), 1);
}

TEST(WorldContacts, ClearForgetsWithoutEvents) {
  Stack stack;
  find(stack.contacts, stack.world, {.margin = 0.01});
  stack.contacts.clear();
  const std::vector<Seen> found = find(stack.contacts, stack.world, {.margin = 0.01});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].event, PairEvent::begin);
}

TEST(WorldContacts, TimesOfFirstContactAlone) {
  Stack stack;
  stack.world.set_motion(stack.upper, {Stack::at(2.5), Stack::at(1)});
  const std::vector<Seen> found = find(stack.contacts, stack.world, {.manifolds = false, .first_contacts = true});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_TRUE(found[0].points.empty());
  ASSERT_TRUE(found[0].first);
  EXPECT_NEAR(found[0].first->time, 2.0 / 3, 1e-6);
}

TEST(WorldContacts, FollowAMeshThatDeforms) {
  World world;
  const TriangleMesh ball = shapes::sphere(3);
  const ShapeId soft = world.add_shape(make_shape(ball));
  const BodyId body = world.add_body(soft, Stack::at(1));
  world.add_body(soft, Stack::at(10));
  const ShapeId board = world.add_shape(make_shape(shapes::box({-4, -4, -1}, {4, 4, 0})));
  world.add_body(board, Pose::Identity(), {.kind = BodyKind::static_});
  EXPECT_THROW(world.set_shape(soft, nullptr), Error);
  WorldContacts contacts;
  std::vector<PairEvent> events;
  // The lower half is flattened, little by little, and comes back.
  for (const double height : {1.0, 1.0, 0.999, 0.99, 0.9, 0.99, 0.999, 1.0}) {
    Vertices vertices = ball.vertices;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) vertices(v, 2) = std::max(vertices(v, 2), -height);
    world.set_shape(soft, refit_shape(*world.shape(soft), vertices));
    const std::vector<Seen> found = find(contacts, world, {.margin = 0.005});
    for (const Seen& seen : found) {
      EXPECT_EQ(seen.a, body);
      events.push_back(seen.event);
      for (const ManifoldPoint& p : seen.points) EXPECT_NEAR(p.separation, 1 - height, 1e-6);
    }
  }
  EXPECT_EQ(events, (std::vector{PairEvent::begin, PairEvent::persist, PairEvent::persist, PairEvent::end,
                                 PairEvent::begin, PairEvent::persist}));
}

TEST(WorldContacts, DoNotAllocateOnceAllPairsHaveBeenThere) {
  Stack stack;
  const auto round = [&] {
    for (const double z : {1.6, 1.5, 1.504}) {
      stack.world.set_pose(stack.upper, Stack::at(z));
      stack.contacts.find(stack.world, {.margin = 0.01}, [](const ContactPair&) {});
    }
  };
  round();
  round();
  const long before = allocations;
  round();
  EXPECT_EQ(allocations, before);
}

TEST(WorldContacts, RefuseWhatTheyCannotWorkWith) {
  Stack stack;
  const auto error_of = [&](const WorldContactOptions& options) -> std::string {
    try {
      stack.contacts.find(stack.world, options, [](const ContactPair&) {});
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_EQ(error_of({.margin = -1}), "contact options: margin -1.000000 is not in [0, 1e150]");
  EXPECT_EQ(error_of({.first_margin = -2}), "contact options: first_margin -2.000000 is not in [0, 1e150]");
  EXPECT_EQ(error_of({.most_points = 0}), "contact options: most_points 0 is not in [1, 1024]");
  EXPECT_EQ(error_of({.most_per_patch = 0}), "contact options: most_per_patch 0 is not positive");
  CageHierarchy cages;
  cages.levels.push_back({});
  cages.levels[0].mesh = shapes::cube(0.625);
  const ShapeId only_cages = stack.world.add_shape(make_shape(cages));
  const BodyId body = stack.world.add_body(only_cages, Stack::at(0.7));
  EXPECT_EQ(error_of({}),
            "body 2: its shape has no fine mesh, which contacts need; bake it with the mesh in the asset");
  stack.world.remove_body(body);
  EXPECT_EQ(error_of({.margin = 0.01}), "none");
}

}  // namespace
}  // namespace encage::test
