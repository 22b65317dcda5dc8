// SPDX-License-Identifier: GPL-3.0-or-later
// How points pass from step to step in the manifolds of a pair.
#include "broadphase/adapters/bullet/mesh_points.h"
#include "oracles/count_allocations.h"

#include <btBulletDynamicsCommon.h>
#include <gtest/gtest.h>

#include <vector>

namespace encage::bullet {
namespace {

class Manifolds : public testing::Test {
 protected:
  Manifolds()
      : dispatcher(&configuration), wrap_a(nullptr, &box, &a, at_a, -1, 3), wrap_b(nullptr, &box, &b, at_b, 5, 6) {
    a.setCollisionShape(&box);
    b.setCollisionShape(&box);
    a.setWorldTransform(at_a);
    b.setWorldTransform(at_b);
    manifolds.begin(dispatcher, 16);
  }
  ~Manifolds() override { manifolds.release(); }

  static ManifoldPoint point(std::uint64_t feature, double x, int patch = 0,
                             const Eigen::Vector3d& normal = {0, 0, 1}) {
    const Eigen::Vector3d at(x, 0, 0);
    return {.point_a = at + 0.01 * normal,
            .point_b = at,
            .normal = normal,
            .separation = 0.01,
            .feature = feature,
            .patch = patch};
  }

  void fill(const std::vector<ManifoldPoint>& points) { manifolds.fill(points, wrap_a, wrap_b, 0.05); }

  std::vector<int> counts() const {
    std::vector<int> all;
    for (const btPersistentManifold* manifold : manifolds.all()) all.push_back(manifold->getNumContacts());
    return all;
  }

  btManifoldPoint& at(int i) { return manifolds.all()[0]->getContactPoint(i); }

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  btBoxShape box{btVector3(1, 1, 1)};
  btCollisionObject a, b;
  btTransform at_a{btQuaternion::getIdentity(), btVector3(0, 0, 1)};
  btTransform at_b{btQuaternion(btVector3(0, 0, 1), SIMD_HALF_PI), btVector3(0, 0, -1)};
  btCollisionObjectWrapper wrap_a, wrap_b;
  PairManifolds manifolds;
};

TEST_F(Manifolds, HoldPointsAsTheyAre) {
  fill({point(1, 0.5)});
  ASSERT_EQ(counts(), std::vector<int>{1});
  const btManifoldPoint& p = at(0);
  EXPECT_FLOAT_EQ(p.getDistance(), 0.01F);
  EXPECT_LT((p.m_localPointA - btVector3(0.5F, 0, -0.99F)).length(), 1e-6);
  EXPECT_LT((p.m_localPointB - btVector3(0, -0.5F, 1)).length(), 1e-6);
  EXPECT_EQ(p.m_index0, 3);
  EXPECT_EQ(p.m_partId1, 5);
  EXPECT_EQ(p.m_index1, 6);
  EXPECT_EQ(manifolds.all()[0]->getBody0(), &a);
}

TEST_F(Manifolds, SplitPatchesOnlyIfTheyMust) {
  fill({point(1, 0, 0), point(2, 1, 0), point(3, 2, 0), point(4, 0, 1), point(5, 1, 1), point(6, 2, 1), point(7, 0, 2),
        point(8, 1, 2)});
  EXPECT_EQ(counts(), (std::vector<int>{3, 3, 2}));
  fill({point(1, 0, 0), point(4, 0, 1), point(2, 1, 0), point(5, 1, 1), point(3, 2, 0)});  // mixed
  EXPECT_EQ(counts(), (std::vector<int>{3, 2, 0}));
  for (int i = 0; i < 3; ++i) EXPECT_FLOAT_EQ(at(i).m_positionWorldOnB.x(), static_cast<float>(i));
  std::vector<ManifoldPoint> full;
  for (int i = 0; i < 16; ++i) full.push_back(point(static_cast<std::uint64_t>(i), i, i / 3));
  fill(full);
  EXPECT_EQ(counts(), (std::vector<int>{4, 4, 4, 4}));
  fill({});
  EXPECT_EQ(counts(), (std::vector<int>{0, 0, 0, 0}));
}

TEST_F(Manifolds, CarryWhatTheSolverStoredByFeature) {
  fill({point(1, 0), point(2, 1)});
  at(0).m_appliedImpulse = 7;
  at(1).m_appliedImpulse = 8;
  at(1).m_appliedImpulseLateral1 = 0.5F;
  fill({point(2, 0.4), point(1, 0.6)});
  EXPECT_FLOAT_EQ(at(0).m_appliedImpulse, 8);
  EXPECT_FLOAT_EQ(at(0).m_appliedImpulseLateral1, 0.5F);
  EXPECT_FLOAT_EQ(at(1).m_appliedImpulse, 7);
  EXPECT_EQ(at(0).getLifeTime(), 1);
  fill({point(2, 0.4)});
  EXPECT_EQ(at(0).getLifeTime(), 2);
}

TEST_F(Manifolds, CarryItByNearnessWhereFeaturesChange) {
  fill({point(1, 0), point(2, 1)});
  at(0).m_appliedImpulse = 7;
  at(1).m_appliedImpulse = 8;
  fill({point(3, 1.03), point(4, 0.1), point(5, -0.02, 0, {0, 0, -1})});
  EXPECT_FLOAT_EQ(at(0).m_appliedImpulse, 8);
  EXPECT_FLOAT_EQ(at(1).m_appliedImpulse, 0);  // too far
  EXPECT_FLOAT_EQ(at(2).m_appliedImpulse, 0);  // the other way
  EXPECT_EQ(at(2).getLifeTime(), 0);
}

TEST_F(Manifolds, DoNotCarryItToTheOtherSideOfAFeature) {
  fill({point(1, 0)});
  at(0).m_appliedImpulse = 7;
  fill({point(1, 0, 0, {0, 0, -1})});
  EXPECT_FLOAT_EQ(at(0).m_appliedImpulse, 0);
}

TEST_F(Manifolds, KeepTheirPointsWhenOthersRefreshThem) {
  fill({point(1, 0), point(2, 1)});
  at(1).m_appliedImpulse = 8;
  const btTransform away(btQuaternion::getIdentity(), {0.3F, 0, 9});
  manifolds.all()[0]->refreshContactPoints(away, at_b);
  ASSERT_EQ(counts(), std::vector<int>{2});
  fill({point(2, 1)});
  EXPECT_FLOAT_EQ(at(0).m_appliedImpulse, 8);
  EXPECT_EQ(at(0).getLifeTime(), 1);
}

TEST_F(Manifolds, SurviveThatOthersRemovePoints) {
  fill({point(1, 0), point(2, 1), point(3, 2)});
  for (int i = 0; i < 3; ++i) at(i).m_appliedImpulse = static_cast<btScalar>(i + 1);
  manifolds.all()[0]->removeContactPoint(0);
  fill({point(1, 0), point(2, 1), point(3, 2)});
  EXPECT_FLOAT_EQ(at(0).m_appliedImpulse, 0);
  EXPECT_FLOAT_EQ(at(1).m_appliedImpulse, 2);
  EXPECT_FLOAT_EQ(at(2).m_appliedImpulse, 3);
}

int destroyed = 0;

TEST_F(Manifolds, PassOnUserDataAndTellWhenItGoes) {
  int data = 0;
  fill({point(1, 0), point(2, 1)});
  at(0).m_userPersistentData = &data;
  gContactDestroyedCallback = [](void*) {
    ++destroyed;
    return true;
  };
  fill({point(2, 1), point(1, 0)});
  EXPECT_EQ(at(1).m_userPersistentData, &data);
  EXPECT_EQ(destroyed, 0);
  fill({point(2, 1)});
  EXPECT_EQ(destroyed, 1);
  gContactDestroyedCallback = nullptr;
}

TEST_F(Manifolds, KeepAnchorsThatFrictionHolds) {
  a.setCollisionFlags(a.getCollisionFlags() | btCollisionObject::CF_HAS_FRICTION_ANCHOR);
  a.setFriction(1);
  b.setFriction(1);
  fill({point(1, 0)});
  at(0).m_appliedImpulse = 10;
  at(0).m_appliedImpulseLateral1 = 3;
  fill({point(1, 0.02)});
  EXPECT_FLOAT_EQ(at(0).m_positionWorldOnB.x(), 0);
  at(0).m_appliedImpulseLateral1 = 30;  // it slides
  fill({point(1, 0.03)});
  EXPECT_FLOAT_EQ(at(0).m_positionWorldOnB.x(), 0.03F);
}

TEST_F(Manifolds, DoNotAllocateOnceTheyAreThere) {
  std::vector<ManifoldPoint> few = {point(1, 0), point(2, 1)}, many;
  for (int i = 0; i < 16; ++i) many.push_back(point(static_cast<std::uint64_t>(i), i, i / 3));
  fill(many);
  const long before = allocations;
  for (const std::vector<ManifoldPoint>& points : {std::cref(few), std::cref(many)}) fill(points);
  EXPECT_EQ(allocations, before);
}

}  // namespace
}  // namespace encage::bullet
