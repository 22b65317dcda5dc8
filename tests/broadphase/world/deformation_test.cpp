// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies that leave their rigid pose: rejects of a world are compared with meshes that are really deformed.
#include "oracles/exact_pair.h"
#include "oracles/sampled.h"
#include "oracles/twin_bodies.h"
#include "tests/broadphase/world/twin.h"

#include <cmath>

namespace encage::test {
namespace {

/// Two bodies, their bounds, and a margin.
struct Scene {
  Scene(TwinRandom& random, const std::vector<Body>& bodies, bool moves)
      : a(random.one_of(bodies)), b(random.one_of(bodies)) {
    const double size = std::min(a.diagonal(), b.diagonal());
    bound_a = random.coin() ? 0 : random.uniform(0.01, 0.3) * size;
    bound_b = random.uniform(0.01, 0.3) * size;
    margin = random.coin() ? 0 : 0.05 * size;
    shapes::Random positions(random.below(1u << 30));
    const double way = moves ? a.diagonal() + b.diagonal() : 0, angle = moves ? 2.5 : 0;
    motion_a = random_motion(positions, random_pose(positions, 3), angle, 0.3 * way);
    motion_b = random_motion(positions, random_pose(positions, 3), angle, 0.3 * way);
    motion_a.scale = a.scale;
    motion_b.scale = b.scale;
    direction = random.direction();
    id_a = world.add_body(world.add_shape(a.shape), motion_a.start, {.scale = a.scale});
    id_b = world.add_body(world.add_shape(b.shape), motion_b.start, {.scale = b.scale});
    world.set_motion(id_a, motion_a);
    world.set_deformation(id_a, bound_a);
    world.set_deformation(id_b, bound_b);
    // Moves the bodies to the border between "separated" and "maybe".
    const double far = 2 * (a.diagonal() + b.diagonal()) + 2 * way + bound_a + bound_b + margin;
    random.near_change(
        [&](double distance) {
          place(distance);
          return rejected(margin);
        },
        far, size);
  }

  void place(double distance) {
    const Vector to = a.centre(motion_a.start) + distance * direction - b.centre(motion_b.start);
    motion_b.start.translation() += to;
    motion_b.end.translation() += to;
    world.set_motion(id_b, motion_b);
  }
  bool rejected(double asked) { return candidates(world, {.pair = {.margin = asked}}).empty(); }

  const Body& a;
  const Body& b;
  double bound_a, bound_b, margin;
  Motion motion_a, motion_b;
  Vector direction;
  World world;
  BodyId id_a, id_b;
};

/// Returns the source with every vertex moved by nearly the bound. The displacement depends on the vertex's position
/// alone: all vertices move towards `direction` (world), or in various directions.
TriangleMesh deformed(const Body& body, const Motion& motion, double bound, const Vector& direction, int way) {
  TriangleMesh mesh = body.sample.source;
  const Eigen::Matrix3d to_body = motion.start.linear().transpose() / motion.scale;
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    const Vector x = mesh.vertices.row(v).transpose() / body.sample.hierarchy.diagonal;
    Vector d = direction;
    if (way > 0) {
      d += Vector(std::sin(9 * x[1] + way), std::sin(11 * x[2] - way), std::sin(7 * x[0])) * 1.5;
      d.normalize();
    }
    mesh.vertices.row(v) += (bound * (1 - 1e-6) * (to_body * d)).transpose();
  }
  return mesh;
}

/// True, exactly, if the bodies are farther apart than the margin and neither contains a part of the other.
bool are_apart(const Scene& s, double bound_a, double bound_b, int way) {
  const ExactBody a(s.a.origin(), deformed(s.a, s.motion_a, bound_a, s.direction, way), s.motion_a.start, s.a.scale);
  const ExactBody b(s.b.origin(), deformed(s.b, s.motion_b, bound_b, -s.direction, way), s.motion_b.start, s.b.scale);
  return !surfaces_meet(a, b, s.margin) && !(s.a.solid() && holds_component(a, b)) &&
         !(s.b.solid() && holds_component(b, a));
}

TEST(DeformedBodies, AreNotMissedAtRest) {
  TwinRandom random(11);
  const std::vector<Body> bodies = twin_bodies();
  int rejects = 0, attacks = 0;
  for (int i = 0; i < 300 && !testing::Test::HasFailure(); ++i) {
    Scene s(random, bodies, false);
    const double sum = s.margin + s.bound_a + s.bound_b;
    const bool rejected = s.rejected(s.margin);
    // The bounds enlarge the margin and cost nothing else.
    if (separated(*s.a.shape, s.motion_a, *s.b.shape, s.motion_b, sum * (1 + 1e-14)).separated) {
      EXPECT_TRUE(rejected) << "pair " << i;
    }
    for (int way = 0; way < 3; ++way) {
      const bool apart = are_apart(s, s.bound_a, s.bound_b, way);
      if (rejected) {
        ASSERT_TRUE(apart) << "pair " << i << ", way " << way << " of " << s.a.sample.name << ", " << s.b.sample.name;
      }
      // A slightly larger deformation touches, so the test would notice a bound that is slightly too small.
      if (rejected && way == 0) attacks += !are_apart(s, 1.1 * s.bound_a + 0.1 * sum, 1.1 * s.bound_b + 0.1 * sum, way);
    }
    rejects += rejected;
  }
  EXPECT_GT(rejects, 100);
  EXPECT_GT(attacks, 50);
}

TEST(DeformedBodies, AreNotMissedDuringAStep) {
  TwinRandom random(12);
  std::vector<Body> bodies = twin_bodies();
  std::erase_if(bodies, [](const Body& body) { return body.scale != 1; });
  int rejects = 0;
  for (int i = 0; i < 120 && !testing::Test::HasFailure(); ++i) {
    Scene s(random, bodies, true);
    if (!s.rejected(s.margin)) continue;
    ++rejects;
    for (int way = 0; way < 3; ++way) {
      const TriangleMesh a = deformed(s.a, s.motion_a, s.bound_a, s.direction, way);
      const TriangleMesh b = deformed(s.b, s.motion_b, s.bound_b, -s.direction, way);
      for (const Real distance :
           least_distances(a, s.a.origin(), s.motion_a, b, s.b.origin(), s.motion_b, s.margin, 12)) {
        ASSERT_GT(distance, s.margin) << "pair " << i << " of " << s.a.sample.name << ", " << s.b.sample.name;
      }
    }
  }
  EXPECT_GT(rejects, 30);
}

TEST(DeformedBodies, AreNotMissedByHalfSpaces) {
  TwinRandom random(13);
  const std::vector<Body> bodies = twin_bodies();
  int rejects = 0;
  for (int i = 0; i < 300; ++i) {
    const Body& body = random.one_of(bodies);
    const double bound = random.uniform(0.01, 0.3) * body.diagonal();
    shapes::Random positions(random.below(1u << 30));
    const Pose pose = random_pose(positions, 3);
    HalfSpace plane{random.direction(), 0};
    const auto rejected = [&](double height) {
      plane.offset = plane.normal.dot(body.centre(pose)) - height;
      World world;
      world.set_deformation(world.add_body(world.add_shape(body.shape), pose, {.scale = body.scale}), bound);
      world.add_half_space(plane);
      return candidates(world).empty();
    };
    bool last = false;
    random.near_change([&](double height) { return last = rejected(height); }, 2 * (body.diagonal() + bound),
                       body.diagonal());
    if (!last) continue;
    ++rejects;
    const Motion motion = Motion::resting(pose, body.scale);
    for (int way = 0; way < 3; ++way) {
      const TriangleMesh mesh = deformed(body, motion, bound, -plane.normal, way);
      ASSERT_TRUE(all_beyond(ExactBody(body.origin(), mesh, pose, body.scale), plane.normal, plane.offset, 0)) << i;
    }
  }
  EXPECT_GT(rejects, 100);
}

TEST(DeformedBodies, CountInTheMarginOfTheirPairsUntilSetAgain) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  const BodyId a = world.add_body(box, shift(0)), b = world.add_body(box, shift(2.5));
  EXPECT_EQ(world.deformation(a), 0);
  EXPECT_EQ(candidates(world).size(), 0u);
  world.set_deformation(a, 0.4);
  world.set_deformation(b, 0.2);
  EXPECT_EQ(world.deformation(b), 0.2);
  EXPECT_EQ(candidates(world).size(), 1u);
  world.set_pose(a, shift(-0.15));
  EXPECT_EQ(candidates(world).size(), 0u);
  EXPECT_EQ(candidates(world, {.pair = {.margin = 0.1}}).size(), 1u);
  // Triangles that may touch after a deformation are reported as well.
  world.set_pose(a, shift(0));
  std::size_t triangles = 0;
  world.find_candidates({.triangles = true}, [&](const CandidatePair& pair) { triangles += pair.triangles.size(); });
  EXPECT_GT(triangles, 0u);
  world.set_deformation(a, 0);
  EXPECT_EQ(candidates(world).size(), 0u);
}

}  // namespace
}  // namespace encage::test
