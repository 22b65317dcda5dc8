// SPDX-License-Identifier: GPL-3.0-or-later
// Worlds behave the same with and without the adapter, step by step and bit for bit.
#include "tests/broadphase/adapters/bullet_world.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace encage::test {
namespace {

struct Case {
  std::string name;
  double margin = 0;
  double scale = 1;
  double width = 8;
  int bodies = 12;
  int steps = 150;
};

btVector3 random_vector(std::minstd_rand& random, double size) {
  const auto number = [&] {
    return static_cast<btScalar>(size * (2 * static_cast<double>(random()) / std::minstd_rand::max() - 1));
  };
  const btScalar x = number(), y = number();
  return {x, y, number()};
}

/// Throws the bodies of the case into a box.
void fill(BulletWorld& world, btGImpactMeshShape& shape, const Case& c) {
  std::minstd_rand random(7);
  for (int i = 0; i < c.bodies; ++i) {
    const btVector3 cell(static_cast<btScalar>(i % 2), static_cast<btScalar>(i / 2 % 2), static_cast<btScalar>(i / 4));
    const btVector3 at = (cell - btVector3(0.5F, 0.5F, 1)) * static_cast<btScalar>(2.6 * c.scale);
    const btQuaternion turn(random_vector(random, 1).normalized(), static_cast<btScalar>(random() % 628) / 100);
    btRigidBody& body = world.add(shape, placed(at, turn));
    body.setLinearVelocity(random_vector(random, 4 * c.scale));
    body.setAngularVelocity(random_vector(random, 4));
  }
  world.add_walls(0.5 * c.width * c.scale);
}

class Simulations : public testing::TestWithParam<Case> {};

TEST_P(Simulations, AreTheSameWithAndWithoutAdapter) {
  const Case c = GetParam();
  const Body body = body_named(c.name);
  const auto s = static_cast<btScalar>(c.scale);
  BulletMesh plain_mesh(BulletMesh::of(body), c.margin, {s, s, s}), mesh(BulletMesh::of(body), c.margin, {s, s, s});
  BulletWorld plain, world(BulletContacts::all);
  world.adapter->attach(mesh.shape(), body.shape);
  fill(plain, plain_mesh.shape(), c);
  fill(world, mesh.shape(), c);
  std::size_t points = 0;
  int steps_with_both = 0;
  for (int i = 0; i < c.steps; ++i) {
    plain.step(1.0 / 120);
    world.step(1.0 / 120);
    ASSERT_EQ(world.contacts(), plain.contacts()) << "step " << i;
    ASSERT_EQ(world.transforms(), plain.transforms()) << "step " << i;
    points += plain.contacts().size();
    steps_with_both += plain.dispatcher.getNumManifolds() > 0;
    ASSERT_EQ(world.dispatcher.getNumManifolds(), plain.dispatcher.getNumManifolds()) << "step " << i;
  }
  const BulletStatistics statistics = world.adapter->statistics();
  RecordProperty("asked", static_cast<int>(statistics.asked));
  RecordProperty("rejected", static_cast<int>(statistics.rejected));
  EXPECT_GT(points, 100U);
  EXPECT_GT(steps_with_both, 20);
  EXPECT_GT(statistics.rejected, statistics.asked / 2);
  EXPECT_LT(statistics.rejected, statistics.asked);
}

INSTANTIATE_TEST_SUITE_P(All, Simulations,
                         testing::Values(Case{"fine torus"}, Case{"fine torus", 0.03}, Case{"fine torus", 0.01, 0.25},
                                         Case{"sphere", 0.02, 3}, Case{"star"}, Case{"star", 0.05, 1.5},
                                         Case{"torus", 0.02}),
                         [](const auto& parameter) { return "Case" + std::to_string(parameter.index); });

TEST(BulletSimulation, StaysTheSameWhenBodiesAreRemovedAndAdded) {
  const Body body = body_named("fine torus");
  BulletMesh plain_mesh(BulletMesh::of(body)), mesh(BulletMesh::of(body));
  BulletWorld plain, world(BulletContacts::all);
  world.adapter->attach(mesh.shape(), body.shape);
  const auto run = [](BulletWorld& w, btGImpactMeshShape& shape) {
    std::vector<std::vector<ContactPoint>> all;
    std::vector<btRigidBody*> bodies;
    for (int i = 0; i < 8; ++i) {
      bodies.push_back(&w.add(shape, placed({1.7F * static_cast<btScalar>(i), 0, 0.1F * static_cast<btScalar>(i)})));
    }
    for (int i = 0; i < 8; ++i) {
      all.push_back(w.detect());
      const auto removed = static_cast<std::size_t>(i);
      w.remove(*bodies[removed]);
      for (const ContactPoint& point : w.contacts()) EXPECT_NE(point.pair.first, i);
      for (const ContactPoint& point : w.contacts()) EXPECT_NE(point.pair.second, i);
      if (i % 3 == 0) w.add(shape, placed({1.7F * static_cast<btScalar>(i), 0.2F, 0}));
      all.push_back(w.detect());
    }
    return all;
  };
  const auto expected = run(plain, plain_mesh.shape());
  EXPECT_EQ(run(world, mesh.shape()), expected);
  EXPECT_GT(expected.front().size(), 0U);
}

}  // namespace
}  // namespace encage::test
