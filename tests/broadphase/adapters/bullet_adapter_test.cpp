// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/meshes.h"
#include "tests/broadphase/adapters/bullet_world.h"

#include <encage/error.h>
#include <encage/primitives.h>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

namespace encage::test {
namespace {

/// Two worlds with two bodies each; the second world has an adapter.
struct Pair {
  BulletMesh mesh_a, mesh_b;
  BulletWorld plain, world;
  std::array<btRigidBody*, 2> first, second;

  Pair(const Body& body, double margin, BulletContacts contacts = BulletContacts::all,
       const btVector3& scaling = {1, 1, 1})
      : mesh_a(BulletMesh::of(body), margin), mesh_b(BulletMesh::of(body), margin, scaling), world(contacts) {
    world.adapter->attach(mesh_a.shape(), body.shape);
    world.adapter->attach(mesh_b.shape(), body.shape);
    for (BulletWorld* w : {&plain, &world}) {
      first[w == &world] = &w->add(mesh_a.shape(), placed({0, 0, 0}));
      second[w == &world] = &w->add(mesh_b.shape(), placed({50, 0, 0}));
    }
  }

  /// Returns the contacts without the adapter, and expects the same ones with it.
  std::vector<ContactPoint> same(const btTransform& a, const btTransform& b) {
    for (const std::size_t i : {0, 1}) {
      first[i]->setWorldTransform(a);
      second[i]->setWorldTransform(b);
    }
    const std::vector<ContactPoint> expected = plain.detect();
    EXPECT_EQ(world.detect(), expected);
    EXPECT_EQ(world.dispatcher.getNumManifolds(), plain.dispatcher.getNumManifolds());
    return expected;
  }

  BulletStatistics asked_since(const BulletStatistics& before) const {
    const BulletStatistics now = world.adapter->statistics();
    return {now.asked - before.asked, now.rejected - before.rejected};
  }
};

btQuaternion random_turn(std::minstd_rand& random) {
  const auto number = [&] { return static_cast<btScalar>(static_cast<double>(random() % 2001) / 1000 - 1); };
  const btScalar x = number(), y = number(), z = number();
  return btQuaternion(x, y, z, number() + 0.01F).normalized();
}

TEST(BulletAdapter, LeavesTheContactsOfResting) {
  std::minstd_rand random(11);
  for (const char* name : {"star", "l", "u", "torus", "shell", "two boxes", "open box", "spiked box", "fine torus"}) {
    const Body body = body_named(name);
    Pair pair(body, 0.01 * static_cast<double>(random() % 3));
    int touching = 0;
    for (int i = 0; i < 120; ++i) {
      const auto way = [&] { return static_cast<btScalar>(static_cast<double>(random() % 3001) / 1000 - 1.5); };
      const btScalar x = way(), y = way();
      // Some positions are far from the origin, where Bullet rounds most.
      const btVector3 origin = i % 4 == 0 ? btVector3(300, -500, 200) : btVector3(0, 0, 0);
      touching += !pair.same(placed(origin, random_turn(random)),
                             placed(origin + btVector3(x, y, way()) * 1.3F, random_turn(random)))
                       .empty();
    }
    EXPECT_GT(touching, 10) << name;
    EXPECT_GT(pair.world.adapter->statistics().rejected, 0) << name;
  }
}

// A cube above a cube, margins of both 0.05: contact up to a distance of 0.1.
TEST(BulletAdapter, KeepsContactsUpToBothMargins) {
  const Body body = body_named("box");
  Pair pair(body, 0.05, BulletContacts::within_margins);
  int touching = 0, apart = 0;
  for (int i = -200; i <= 200; ++i) {
    const double gap = 0.1 + 2e-7 * i * std::abs(i);
    const bool contact = !pair.same(placed({0, 0, 0}), placed({0.1F, 0.2F, static_cast<btScalar>(2 + gap)})).empty();
    (contact ? touching : apart) += 1;
  }
  EXPECT_GT(touching, 150);
  EXPECT_GT(apart, 150);
  EXPECT_GT(pair.world.adapter->statistics().rejected, 100);
}

TEST(BulletAdapter, KeepsContactsWithPlanesUpToBothMargins) {
  const Body body = body_named("star");
  BulletMesh mesh(BulletMesh::of(body), 0.05);
  BulletWorld plain, world(BulletContacts::all);
  world.adapter->attach(mesh.shape(), body.shape);
  btStaticPlaneShape floor({0.6F, 0, 0.8F}, 0.3F);
  floor.setMargin(0.02F);
  std::minstd_rand random(2);
  const btTransform tilted = placed({3, 1, -2}, random_turn(random));
  const btVector3 normal = tilted.getBasis() * floor.getPlaneNormal();
  std::array<btRigidBody*, 2> bodies{};
  for (BulletWorld* w : {&plain, &world}) {
    w->add(floor, tilted, 0);
    bodies[w == &world] = &w->add(mesh.shape(), placed({0, 0, 0}));
  }
  int touching = 0, apart = 0;
  for (int i = 0; i < 300; ++i) {
    // The heights are at and near the one at which the star's tip is at the margins.
    const btScalar off = static_cast<btScalar>(i % 3 == 0 ? 1e-5 * (i - 150) : 0.01 * (i - 150));
    const btTransform pose = placed(tilted * (floor.getPlaneNormal() * (0.3F + 0.07F + 1 + off)),
                                    i % 3 == 0 ? shortestArcQuat({0, 0, 1}, normal) : random_turn(random));
    for (btRigidBody* b : bodies) b->setWorldTransform(pose);
    const std::vector<ContactPoint> expected = plain.detect();
    ASSERT_EQ(world.detect(), expected) << i;
    (expected.empty() ? apart : touching) += 1;
  }
  EXPECT_GT(touching, 60);
  EXPECT_GT(apart, 60);
  EXPECT_GT(world.adapter->statistics().rejected, apart / 2);
}

// The outer faces of two parallel plates are back to back. GImpact takes them for deep in each other if the plates are
// askew to the axes, so that boxes of triangles overlap.
TEST(BulletAdapter, KeepsFalseContactsUnlessToldOtherwise) {
  CageHierarchy hierarchy;
  hierarchy.fine = shapes::box({-1, -1, -0.0625}, {1, 1, 0.0625});
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 0.5, 0).normalized()).toRotationMatrix();
  hierarchy.fine.vertices = (hierarchy.fine.vertices * turn.transpose()).cast<float>().cast<double>().eval();
  hierarchy.diagonal = 3;
  const Body plate(Sample{"plate", hierarchy.fine, hierarchy});
  const Eigen::Vector3f up = (0.4 * turn.col(2)).cast<float>();
  Pair all(plate, 0), within(plate, 0, BulletContacts::within_margins);
  const btTransform above = placed({up.x(), up.y(), up.z()});
  EXPECT_FALSE(all.same(placed({0, 0, 0}), above).empty());
  within.second[1]->setWorldTransform(above);
  EXPECT_TRUE(within.world.detect().empty());
  EXPECT_EQ(within.world.adapter->statistics().rejected, 1);
}

TEST(BulletAdapter, ReleasesStaleManifolds) {
  Pair pair(body_named("fine torus"), 0);
  // One ring first passes through the other, then lies in its hole without touching it.
  const btQuaternion upright(btVector3(1, 0, 0), static_cast<btScalar>(SIMD_HALF_PI));
  EXPECT_FALSE(pair.same(placed({0, 0, 0}), placed({0.5F, 0, 0}, upright)).empty());
  EXPECT_GT(pair.world.dispatcher.getNumManifolds(), 0);
  const BulletStatistics before = pair.world.adapter->statistics();
  EXPECT_TRUE(pair.same(placed({0, 0, 0}), placed({1, 0, 0}, upright)).empty());
  EXPECT_EQ(pair.asked_since(before).rejected, 1);
  EXPECT_EQ(pair.world.dispatcher.getNumManifolds(), 0);
  btManifoldArray manifolds;
  btBroadphasePairArray& pairs = pair.world.broadphase.getOverlappingPairCache()->getOverlappingPairArray();
  ASSERT_EQ(pairs.size(), 1);
  pairs[0].m_algorithm->getAllContactManifolds(manifolds);
  EXPECT_EQ(manifolds.size(), 0);
  EXPECT_FALSE(pair.same(placed({0, 0, 0}), placed({0.5F, 0, 0}, upright)).empty());
}

TEST(BulletAdapter, RejectsScaledMeshesIfAllAxesAreAlike) {
  const Body body = body_named("fine torus");
  for (const btVector3& scaling : {btVector3(2, 2, 2), btVector3(0.3F, 0.3F, 0.3F), btVector3(1, 2, 1)}) {
    Pair pair(body, 0.01, BulletContacts::all, scaling);
    std::minstd_rand random(6);
    int touching = 0;
    for (int i = 0; i < 90; ++i) {
      const btVector3 at(0.03F * static_cast<btScalar>(i), 0, 0.4F);
      touching += !pair.same(placed({0, 0, 0}, random_turn(random)), placed(at, random_turn(random))).empty();
    }
    EXPECT_GT(touching, 5);
    const BulletStatistics statistics = pair.world.adapter->statistics();
    EXPECT_EQ(statistics.rejected > 5, scaling.y() == scaling.x());
    EXPECT_EQ(statistics.asked > 0, scaling.y() == scaling.x());
  }
}

TEST(BulletAdapter, HandsOnWhatIsNotAttachedOrHasChanged) {
  const Body body = body_named("fine torus");
  Pair pair(body, 0);
  const auto rejected = [&] {
    const BulletStatistics before = pair.world.adapter->statistics();
    EXPECT_TRUE(pair.same(placed({0, 0, 0}), placed({2.2F, 2.2F, 0})).empty());
    return pair.asked_since(before).rejected;
  };
  EXPECT_EQ(rejected(), 1);
  EXPECT_TRUE(pair.world.adapter->detach(pair.mesh_b.shape()));
  EXPECT_FALSE(pair.world.adapter->detach(pair.mesh_b.shape()));
  EXPECT_EQ(rejected(), 0);
  pair.world.adapter->attach(pair.mesh_b.shape(), body.shape);
  EXPECT_EQ(rejected(), 1);
  pair.mesh_b.shape().setMargin(0.1F);
  pair.mesh_b.shape().updateBound();
  EXPECT_EQ(rejected(), 0);
  pair.world.adapter->attach(pair.mesh_b.shape(), body.shape);
  EXPECT_EQ(rejected(), 1);
  pair.mesh_b.shape().setLocalScaling({0.8F, 0.8F, 0.8F});
  pair.mesh_b.shape().updateBound();
  EXPECT_EQ(rejected(), 0);
  pair.world.adapter->attach(pair.mesh_b.shape(), body.shape);
  EXPECT_EQ(rejected(), 1);
}

TEST(BulletAdapter, HandsOnConvexShapesAndPartsOfCompounds) {
  const Body body = body_named("fine torus");
  BulletMesh mesh(BulletMesh::of(body));
  btSphereShape sphere(0.5F);
  btCompoundShape compound;
  compound.addChildShape(placed({0.2F, 0, 0}), &mesh.shape());
  BulletWorld plain, world(BulletContacts::all);
  world.adapter->attach(mesh.shape(), body.shape);
  std::array<std::array<btRigidBody*, 3>, 2> bodies{};
  for (BulletWorld* w : {&plain, &world}) {
    bodies[w == &world] = {&w->add(mesh.shape(), placed({0, 0, 0})), &w->add(sphere, placed({0, 0, 0})),
                           &w->add(compound, placed({0, 0, 0}), 0)};
  }
  std::minstd_rand random(8);
  std::size_t points = 0;
  for (int i = 0; i < 80; ++i) {
    const btQuaternion turn = random_turn(random), other = random_turn(random);
    const btScalar way = 0.04F * static_cast<btScalar>(i);
    for (const auto& three : bodies) {
      three[1]->setWorldTransform(placed({way, 0.3F, 0}, turn));
      three[2]->setWorldTransform(placed({0, way, 0.5F}, other));
    }
    const std::vector<ContactPoint> expected = plain.detect();
    ASSERT_EQ(world.detect(), expected) << i;
    points += expected.size();
  }
  EXPECT_GT(points, 100U);
  EXPECT_EQ(world.adapter->statistics().asked, 0);
}

/// Counts calls, and reports a time of impact.
struct Counting : btCollisionAlgorithm {
  using btCollisionAlgorithm::btCollisionAlgorithm;
  static inline int calls = 0, times = 0;
  void processCollision(const btCollisionObjectWrapper*, const btCollisionObjectWrapper*, const btDispatcherInfo&,
                        btManifoldResult*) override {
    ++calls;
  }
  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    ++times;
    return 0.25F;
  }
  void getAllContactManifolds(btManifoldArray&) override {}
  struct Create : btCollisionAlgorithmCreateFunc {
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper*,
                                                   const btCollisionObjectWrapper*) override {
      return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(Counting))) Counting(info);
    }
  };
};

// A user's algorithm may keep contacts up to the breaking threshold, 0.02.
TEST(BulletAdapter, RefusesShapesWithARadiusThatBulletsMeshHasNot) {
  const Body body = body_named("box");
  BulletMesh mesh(BulletMesh::of(body));
  BulletWorld world(BulletContacts::all);
  EXPECT_THROW(world.adapter->attach(mesh.shape(), make_sphere(1)), Error);
}

TEST(BulletAdapter, AsksOtherAlgorithmsUpToTheBreakingThreshold) {
  const Body body = body_named("box");
  Counting::Create create;
  BulletMesh mesh(BulletMesh::of(body), 0.05);
  BulletWorld world;
  world.dispatcher.registerCollisionCreateFunc(GIMPACT_SHAPE_PROXYTYPE, GIMPACT_SHAPE_PROXYTYPE, &create);
  world.adapter = std::make_unique<BulletAdapter>(world.dispatcher, BulletContacts::within_margins);
  world.adapter->attach(mesh.shape(), body.shape);
  btRigidBody& a = world.add(mesh.shape(), placed({0, 0, 0}));
  btRigidBody& b = world.add(mesh.shape(), placed({0, 0, 0}));
  const auto asked = [&](double gap) {
    b.setWorldTransform(placed({0, 0, static_cast<btScalar>(2 + gap)}));
    Counting::calls = 0;
    world.detect();
    return Counting::calls == 1;
  };
  const double threshold = static_cast<double>(std::min(a.getCollisionShape()->getContactBreakingThreshold(0.02F),
                                                        b.getCollisionShape()->getContactBreakingThreshold(0.02F)));
  EXPECT_GT(threshold, 0.02);
  EXPECT_TRUE(asked(0.1 + threshold));
  EXPECT_TRUE(asked(0.1 + 1.49 * threshold));
  EXPECT_FALSE(asked(0.1 + 1.51 * threshold));

  world.world.getDispatchInfo().m_dispatchFunc = btDispatcherInfo::DISPATCH_CONTINUOUS;
  world.world.getDispatchInfo().m_timeOfImpact = 1;
  b.setWorldTransform(placed({0, 0, 2.14F}));
  world.detect();
  EXPECT_EQ(Counting::times, 1);
  EXPECT_EQ(world.world.getDispatchInfo().m_timeOfImpact, 0.25F);
}

TEST(BulletAdapter, MayGoBeforeItsWorld) {
  const Body body = body_named("fine torus");
  Pair pair(body, 0);
  const btQuaternion upright(btVector3(1, 0, 0), static_cast<btScalar>(SIMD_HALF_PI));
  EXPECT_TRUE(pair.same(placed({0, 0, 0}), placed({1, 0, 0}, upright)).empty());
  pair.world.adapter.reset();
  EXPECT_FALSE(pair.same(placed({0, 0, 0}), placed({0.5F, 0, 0}, upright)).empty());
  EXPECT_TRUE(pair.same(placed({0, 0, 0}), placed({1, 0, 0}, upright)).empty());
  // From now on Bullet creates its own algorithms.
  const btCollisionObjectWrapper a(nullptr, &pair.mesh_a.shape(), pair.first[1], pair.first[1]->getWorldTransform(), -1,
                                   -1);
  btCollisionAlgorithm* const made = pair.world.dispatcher.findAlgorithm(&a, &a, nullptr, BT_CONTACT_POINT_ALGORITHMS);
  EXPECT_NE(dynamic_cast<btGImpactCollisionAlgorithm*>(made), nullptr);
  made->~btCollisionAlgorithm();
  pair.world.dispatcher.freeCollisionAlgorithm(made);
}

TEST(BulletAdapter, RefusesBadMeshes) {
  const Body body = body_named("star");
  BulletWorld world(BulletContacts::all);
  const auto message = [&](const btGImpactMeshShape& mesh, const ShapePtr& shape) -> std::string {
    try {
      world.adapter->attach(mesh, shape);
    } catch (const Error& error) {
      EXPECT_FALSE(world.adapter->detach(mesh));
      return error.what();
    }
    return "attached";
  };
  BulletMesh good(BulletMesh::of(body)), margin(BulletMesh::of(body), -1);
  EXPECT_EQ(message(good.shape(), body.shape), "attached");
  EXPECT_TRUE(world.adapter->detach(good.shape()));
  EXPECT_NE(message(good.shape(), nullptr).find("null"), std::string::npos);
  EXPECT_NE(message(margin.shape(), body.shape).find("margin -1"), std::string::npos);
  EXPECT_NE(message(good.shape(), body_named("torus").shape).find("another unit, frame or mesh"), std::string::npos);
  const Body cages(without_fine(body.sample));
  EXPECT_EQ(message(good.shape(), cages.shape), "attached");
  BulletMesh large(shapes::scaled(BulletMesh::of(body), 1.5));
  EXPECT_NE(message(large.shape(), cages.shape).find("another unit"), std::string::npos);
  TriangleMesh broken = BulletMesh::of(body);
  broken.vertices(3, 1) = std::numeric_limits<double>::quiet_NaN();
  BulletMesh nan(broken);
  EXPECT_NE(message(nan.shape(), body.shape).find("vertex 3 of part 0 is not finite"), std::string::npos);
  btTriangleIndexVertexArray arrays;
  btGImpactMeshShape empty(&arrays);
  EXPECT_NE(message(empty, body.shape).find("no triangles"), std::string::npos);
}

}  // namespace
}  // namespace encage::test
