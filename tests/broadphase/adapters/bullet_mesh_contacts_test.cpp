// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/adapters/bullet_mesh_world.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>
#include <string>

namespace encage::test {
namespace {

using shapes::box;
using shapes::cube;

using ShapeMaker = std::function<btCollisionShape&(MeshWorld&)>;

TriangleMesh square(double half) {
  return shapes::mesh({{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}}, {{0, 1, 2}, {0, 2, 3}});
}

/// A triangle mesh of Bullet's, with its arrays.
class SquareShape final : public btBvhTriangleMeshShape {
 public:
  explicit SquareShape(std::unique_ptr<btTriangleMesh> triangles)
      : btBvhTriangleMeshShape(triangles.get(), true), triangles_(std::move(triangles)) {}
  static std::unique_ptr<SquareShape> make(double half) {
    auto triangles = std::make_unique<btTriangleMesh>();
    const TriangleMesh mesh = square(half);
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      std::array<btVector3, 3> corners;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3f x = mesh.corner(t, k).cast<float>();
        corners[static_cast<std::size_t>(k)] = {x.x(), x.y(), x.z()};
      }
      triangles->addTriangle(corners[0], corners[1], corners[2]);
    }
    return std::make_unique<SquareShape>(std::move(triangles));
  }

 private:
  std::unique_ptr<btTriangleMesh> triangles_;
};

class FlatTerrain final : public btHeightfieldTerrainShape {
 public:
  explicit FlatTerrain(std::unique_ptr<std::vector<float>> heights)
      : btHeightfieldTerrainShape(9, 9, heights->data(), 0.F, 1.F, 2, false), heights_(std::move(heights)) {}

 private:
  std::unique_ptr<std::vector<float>> heights_;
};

template <class Shape>
Shape& with_margin(Shape& shape, double margin) {
  shape.setMargin(static_cast<btScalar>(margin));
  return shape;
}

struct Ground {
  std::string name;
  ShapeMaker make;
  double below = 0;   // of the origin below the top
  double margin = 0;  // above the top
};

const std::vector<Ground>& grounds() {
  static const std::vector<Ground> all = {
      {"plane",
       [](MeshWorld& w) -> btCollisionShape& {
         return w.keep(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0));
       }},
      {"box",
       [](MeshWorld& w) -> btCollisionShape& { return w.keep(std::make_unique<btBoxShape>(btVector3(4, 4, 1))); }, 1},
      {"mesh",
       [](MeshWorld& w) -> btCollisionShape& {
         return w.keep(mesh_shape(box({-4, -4, -1}, {4, 4, 1})));
       },
       1},
      {"rounded mesh",
       [](MeshWorld& w) -> btCollisionShape& {
         return with_margin(w.keep(mesh_shape(box({-4, -4, -1}, {4, 4, 1}))), 0.1);
       },
       1, 0.1},
      {"hull",
       [](MeshWorld& w) -> btCollisionShape& {
         auto hull = std::make_unique<btConvexHullShape>();
         for (int i = 0; i < 8; ++i) {
           hull->addPoint({i & 1 ? 4.F : -4.F, i & 2 ? 4.F : -4.F, i & 4 ? 1.F : -1.F});
         }
         return with_margin(w.keep(std::move(hull)), 0.06);
       },
       1, 0.06},
      {"cylinder",
       [](MeshWorld& w) -> btCollisionShape& { return w.keep(std::make_unique<btCylinderShapeZ>(btVector3(4, 4, 1))); },
       1},
      {"cone upside down",
       [](MeshWorld& w) -> btCollisionShape& {
         auto compound = std::make_unique<btCompoundShape>();
         auto& cone = with_margin(w.keep(std::make_unique<btConeShapeZ>(4.F, 2.F)), 0.05);
         compound->addChildShape(btTransform(btQuaternion(btVector3(1, 0, 0), SIMD_PI)), &cone);
         return w.keep(std::move(compound));
       },
       1, 0.05},
      {"triangle mesh", [](MeshWorld& w) -> btCollisionShape& { return w.keep(SquareShape::make(4)); }},
      {"triangle mesh with margin",
       [](MeshWorld& w) -> btCollisionShape& { return with_margin(w.keep(SquareShape::make(4)), 0.04); }, 0, 0.04},
      {"height field",
       [](MeshWorld& w) -> btCollisionShape& {
         return w.keep(std::make_unique<FlatTerrain>(std::make_unique<std::vector<float>>(81, 0.5F)));
       }},
      {"compound of meshes",
       [](MeshWorld& w) -> btCollisionShape& {
         auto compound = std::make_unique<btCompoundShape>();
         auto& half = w.keep(mesh_shape(box({-2, -4, -1}, {2, 4, 1})));
         compound->addChildShape(btTransform(btQuaternion::getIdentity(), {-2, 0, 0}), &half);
         compound->addChildShape(btTransform(btQuaternion::getIdentity(), {2, 0, 0}), &half);
         return w.keep(std::move(compound));
       },
       1},
  };
  return all;
}

struct Guest {
  std::string name;
  ShapeMaker make;
  double below = 0.5;  // of the bottom below the origin
};

const std::vector<Guest>& guests() {
  static const std::vector<Guest> all = {
      {"cube", [](MeshWorld& w) -> btCollisionShape& { return w.keep(mesh_shape(cube(0.5))); }},
      {"scaled cube",
       [](MeshWorld& w) -> btCollisionShape& {
         auto& shape = w.keep(mesh_shape(cube(0.25)));
         shape.setLocalScaling({2, 2, 2});
         return shape;
       }},
      {"rounded cube",
       [](MeshWorld& w) -> btCollisionShape& { return with_margin(w.keep(mesh_shape(cube(0.4))), 0.1); }},
      {"compound shape",
       [](MeshWorld& w) -> btCollisionShape& {
         const ShapePtr part = make_shape(cube(0.5));
         const std::array<CompoundPart, 2> parts = {
             CompoundPart{part, Eigen::Isometry3d(Eigen::Translation3d(-1, 0, 0))},
             CompoundPart{part, Eigen::Isometry3d(Eigen::Translation3d(1, 0, 0))}};
         return w.keep(std::make_unique<BulletMeshShape>(make_compound(parts)));
       }},
      {"eccentric slab",  // its shortest axis has the largest moment and becomes z
       [](MeshWorld& w) -> btCollisionShape& {
         const BulletMeshShapeOptions options{.frame = BulletFrame::principal};
         return w.keep(std::make_unique<BulletMeshShape>(make_shape(box({3, 1, 2}, {4, 2.5, 4})), options));
       }},
      {"compound of cubes", [](MeshWorld& w) -> btCollisionShape& {
         auto compound = std::make_unique<btCompoundShape>();
         auto& part = w.keep(mesh_shape(cube(0.5)));
         compound->addChildShape(btTransform(btQuaternion::getIdentity(), {-1, 0, 0}), &part);
         compound->addChildShape(btTransform(btQuaternion::getIdentity(), {1, 0, 0}), &part);
         return w.keep(std::move(compound));
       }}};
  return all;
}

/// Mesh bodies on grounds of all kinds. Bullet orders a pair by the age of its bodies: both orders.
class MeshRests : public testing::TestWithParam<std::tuple<std::size_t, std::size_t, bool>> {};

TEST_P(MeshRests, OnTheGround) {
  const Ground& ground = grounds()[std::get<0>(GetParam())];
  const Guest& guest = guests()[std::get<1>(GetParam())];
  const bool ground_first = std::get<2>(GetParam());
  MeshWorld w;
  btCollisionShape &below = ground.make(w), &above = guest.make(w);
  const btVector3 ground_at(0, 0, static_cast<btScalar>(-ground.below));
  const btVector3 at(0.1F, 0.2F, static_cast<btScalar>(guest.below + ground.margin + 0.3));
  if (ground_first) w.add(below, ground_at, 0);
  btRigidBody& body = w.add(above, at);
  if (!ground_first) w.add(below, ground_at, 0);
  body.setActivationState(DISABLE_DEACTIVATION);
  w.run(2);
  const btVector3 rest = body.getWorldTransform().getOrigin();
  EXPECT_NEAR(rest.z(), guest.below + ground.margin, 0.005);
  EXPECT_NEAR(rest.x(), 0.1, 0.01);
  EXPECT_NEAR(rest.y(), 0.2, 0.01);
  EXPECT_LT(body.getLinearVelocity().length(), 0.01);
  EXPECT_LT(body.getAngularVelocity().length(), 0.02);
  EXPECT_GE(w.points().size(), 3U);
  EXPECT_NEAR(w.impulse(), 10.0 / 60, 0.02 / 6);
  for (const btManifoldPoint& p : w.points()) {
    EXPECT_NEAR(std::abs(p.m_normalWorldOnB.z()), 1, 1e-3);
    EXPECT_NEAR(p.getDistance(), 0, 0.01);
  }
}

std::string test_name(std::string name) {
  for (char& c : name) c = c == ' ' ? '_' : c;
  return name;
}

std::string rest_name(const testing::TestParamInfo<MeshRests::ParamType>& info) {
  const auto& [ground, guest, ground_first] = info.param;
  return test_name(guests()[guest].name + (ground_first ? " over " : " over younger ") + grounds()[ground].name);
}

INSTANTIATE_TEST_SUITE_P(All, MeshRests,
                         testing::Combine(testing::Range(std::size_t{0}, grounds().size()),
                                          testing::Range(std::size_t{0}, guests().size()), testing::Bool()),
                         rest_name);

/// Bullet's own bodies on a mesh.
struct Roller {
  std::string name;
  ShapeMaker make;
  double below = 0.5;
};

const std::vector<Roller>& rollers() {
  static const std::vector<Roller> all = {
      {"sphere", [](MeshWorld& w) -> btCollisionShape& { return w.keep(std::make_unique<btSphereShape>(0.5F)); }},
      {"capsule",
       [](MeshWorld& w) -> btCollisionShape& { return w.keep(std::make_unique<btCapsuleShapeX>(0.5F, 1.F)); }},
      {"standing capsule",
       [](MeshWorld& w) -> btCollisionShape& { return w.keep(std::make_unique<btCapsuleShapeZ>(0.5F, 1.F)); }, 1},
      {"box",
       [](MeshWorld& w) -> btCollisionShape& { return w.keep(std::make_unique<btBoxShape>(btVector3(1, 1, 0.5F))); }},
      {"cylinder",
       [](MeshWorld& w) -> btCollisionShape& {
         return w.keep(std::make_unique<btCylinderShapeZ>(btVector3(1, 1, 0.5F)));
       }},
      {"cone",
       [](MeshWorld& w) -> btCollisionShape& {
         return with_margin(w.keep(std::make_unique<btConeShapeZ>(1.F, 0.9F)), 0.05);
       }},
      {"simplex",
       [](MeshWorld& w) -> btCollisionShape& {
         auto simplex = std::make_unique<btBU_Simplex1to4>(btVector3(1, 0, -0.4F), btVector3(-1, 1, -0.4F),
                                                           btVector3(-1, -1, -0.4F), btVector3(-0.2F, 0, 0.5F));
         return with_margin(w.keep(std::move(simplex)), 0.1);
       }},
      {"two balls",
       [](MeshWorld& w) -> btCollisionShape& {
         const std::array<btVector3, 2> centres = {btVector3(-1, 0, 0), btVector3(1, 0, 0)};
         const std::array<btScalar, 2> radii = {0.5F, 0.5F};
         return w.keep(std::make_unique<btMultiSphereShape>(centres.data(), radii.data(), 2));
       }},
  };
  return all;
}

class RestsOnMesh : public testing::TestWithParam<std::size_t> {};

TEST_P(RestsOnMesh, WhereItMust) {
  const Roller& roller = rollers()[GetParam()];
  MeshWorld w;
  w.add(w.keep(mesh_shape(box({-4, -4, -1}, {4, 4, 0}))), {0, 0, 0}, 0);
  btRigidBody& body = w.add(roller.make(w), {0, 0, static_cast<btScalar>(roller.below + 0.2)});
  body.setActivationState(DISABLE_DEACTIVATION);
  w.run(1.5);
  EXPECT_NEAR(body.getWorldTransform().getOrigin().z(), roller.below, 0.005);
  EXPECT_LT(body.getLinearVelocity().length(), 0.02);
  EXPECT_GE(w.points().size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(All, RestsOnMesh, testing::Range(std::size_t{0}, rollers().size()),
                         [](const auto& parameter) { return test_name(rollers()[parameter.param].name); });

/// An open cup with a thick bottom: walls around a square hole.
TriangleMesh cup() {
  TriangleMesh mesh = box({-2, -2, -2}, {2, 2, -1});
  for (const TriangleMesh& wall : {box({-2, -2, -1}, {-1, 2, 1}), box({1, -2, -1}, {2, 2, 1}),
                                   box({-1, -2, -1}, {1, -1, 1}), box({-1, 1, -1}, {1, 2, 1})}) {
    mesh = shapes::joined(mesh, wall);
  }
  return mesh;
}

TEST(BulletMeshContacts, KeepASphereInACup) {
  MeshWorld w;
  btRigidBody& bowl = w.add(w.keep(mesh_shape(cup())), {0, 0, 2}, 20);
  btRigidBody& ball = w.add(w.keep(std::make_unique<btSphereShape>(0.5F)), {0.3F, -0.2F, 3});
  w.add(w.keep(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), 0)), {0, 0, 0}, 0);
  bowl.setActivationState(DISABLE_DEACTIVATION);
  w.run(3);
  EXPECT_NEAR(bowl.getWorldTransform().getOrigin().z(), 2, 0.01);
  EXPECT_NEAR(ball.getWorldTransform().getOrigin().z(), 2 - 1 + 0.5, 0.01);
}

TEST(BulletMeshContacts, CarryImpulses) {
  MeshWorld w;
  w.add(w.keep(mesh_shape(box({-4, -4, -1}, {4, 4, 0}))), {0, 0, 0}, 0);
  btRigidBody& body = w.add(w.keep(mesh_shape(cube(0.5))), {0, 0, 0.55F});
  body.setActivationState(DISABLE_DEACTIVATION);
  w.run(1);
  const double impulse = w.impulse();
  EXPECT_NEAR(impulse, 10.0 / 60, 1e-3);
  std::set<int> ages;
  for (const btManifoldPoint& point : w.points()) ages.insert(point.getLifeTime());
  w.world.performDiscreteCollisionDetection();
  EXPECT_NEAR(w.impulse(), impulse, 1e-6);
  for (const btManifoldPoint& point : w.points()) {
    EXPECT_TRUE(ages.count(point.getLifeTime() - 1)) << point.getLifeTime();
    EXPECT_GT(point.getLifeTime(), 20);
  }
}

TEST(BulletMeshContacts, LetBodiesSleepAndWake) {
  MeshWorld w;
  w.add(w.keep(mesh_shape(box({-4, -4, -1}, {4, 4, 0}))), {0, 0, 0}, 0);
  auto& shape = w.keep(mesh_shape(cube(0.5)));
  btRigidBody &lower = w.add(shape, {0, 0, 0.5F}), &upper = w.add(shape, {0.1F, 0, 1.5F});
  w.run(4);
  EXPECT_EQ(lower.getActivationState(), ISLAND_SLEEPING);
  EXPECT_EQ(upper.getActivationState(), ISLAND_SLEEPING);
  const std::size_t points = w.points().size();
  EXPECT_GE(points, 6U);
  w.run(1);
  EXPECT_EQ(w.points().size(), points);
  EXPECT_EQ(upper.getLinearVelocity(), btVector3(0, 0, 0));
  w.add(shape, {0.3F, 0, 2.6F});
  w.run(0.5);
  EXPECT_TRUE(lower.isActive());
  EXPECT_TRUE(upper.isActive());
  w.run(5);
  EXPECT_EQ(lower.getActivationState(), ISLAND_SLEEPING);
  EXPECT_NEAR(upper.getWorldTransform().getOrigin().z(), 1.5, 0.01)
      << "at " << upper.getWorldTransform().getOrigin().x();
}

TEST(BulletMeshContacts, StopFastBodiesBeforeTheyEnter) {
  MeshWorld w;
  w.add(w.keep(mesh_shape(box({-4, -4, -1}, {4, 4, 0}))), {0, 0, 0}, 0);
  btRigidBody& body = w.add(w.keep(mesh_shape(cube(0.5))), {0, 0, 1.03F});
  body.setLinearVelocity({0, 0, -20});  // a third of its size in each step
  btScalar lowest = 1;
  for (int i = 0; i < 30; ++i) {
    w.run(1.0 / 60);
    lowest = std::min(lowest, body.getWorldTransform().getOrigin().z());
  }
  EXPECT_GT(lowest, 0.5 - 0.002);
}

TEST(BulletMeshContacts, HaveRightLocalPointsInCompounds) {
  MeshWorld w;
  auto& part = w.keep(mesh_shape(cube(0.5)));
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(btTransform(btQuaternion::getIdentity(), {-3, 0, 0}), &part);
  compound->addChildShape(btTransform(btQuaternion(btVector3(0, 0, 1), SIMD_HALF_PI), {3, 0, 0}), &part);
  auto& both = w.keep(std::move(compound));
  btRigidBody& a = w.add(both, {0, 0, 0});
  btRigidBody& b = w.add(both, {6.1F, 0.2F, 1.002F});  // its left part above a's right one
  w.world.performDiscreteCollisionDetection();
  ASSERT_GE(w.points().size(), 4U);
  for (const btManifoldPoint& point : w.points()) {
    EXPECT_NEAR(point.m_localPointA.z(), 0.5, 1e-5);
    EXPECT_NEAR(point.m_localPointA.x(), 3, 0.5 + 1e-5);
    EXPECT_NEAR(point.m_localPointB.z(), -0.5, 1e-5);
    EXPECT_NEAR(point.m_localPointB.x(), -3, 0.5 + 1e-5);
    EXPECT_EQ(point.m_index0, 1);
    EXPECT_EQ(point.m_index1, 0);
    EXPECT_NEAR(point.getDistance(), 0.002, 1e-5);
    EXPECT_LT((a.getWorldTransform() * point.m_localPointA - point.m_positionWorldOnA).length(), 1e-5);
    EXPECT_LT((b.getWorldTransform() * point.m_localPointB - point.m_positionWorldOnB).length(), 1e-5);
  }
}

/// Points as a contact test gets them.
struct Tested : btCollisionWorld::ContactResultCallback {
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* a, int, int,
                           const btCollisionObjectWrapper* b, int, int) override {
    points.push_back(point);
    first = a->getCollisionObject();
    second = b->getCollisionObject();
    return 0;
  }
  std::vector<btManifoldPoint> points;
  const btCollisionObject *first = nullptr, *second = nullptr;
};

TEST(BulletMeshContacts, AnswerContactTests) {
  MeshWorld w;
  auto& shape = w.keep(mesh_shape(cube(0.5)));
  btRigidBody &a = w.add(shape, {0, 0, 0}), &b = w.add(shape, {0.2F, 0.1F, 0.99F});
  btRigidBody& far = w.add(shape, {0, 0, 1.7F + 1});
  for (const bool swapped : {false, true}) {
    Tested tested;
    w.world.contactPairTest(swapped ? &b : &a, swapped ? &a : &b, tested);
    ASSERT_GE(tested.points.size(), 4U);
    EXPECT_EQ(tested.first, swapped ? &b : &a);
    for (const btManifoldPoint& point : tested.points) {
      EXPECT_NEAR(point.getDistance(), -0.01, 1e-5);
      EXPECT_NEAR(point.m_normalWorldOnB.z(), swapped ? 1 : -1, 1e-5);
      EXPECT_NEAR(point.getPositionWorldOnB().z(), swapped ? 0.5 : 0.49, 1e-5);
    }
  }
  Tested none, near;
  w.world.contactPairTest(&a, &far, none);
  EXPECT_TRUE(none.points.empty());
  near.m_closestDistanceThreshold = 2;
  w.world.contactPairTest(&a, &far, near);
  ASSERT_FALSE(near.points.empty());
  EXPECT_NEAR(near.points.front().getDistance(), 1.7, 1e-5);
  Tested all;
  w.world.contactTest(&b, all);
  EXPECT_GE(all.points.size(), 4U);
  EXPECT_EQ(w.dispatcher.getNumManifolds(), 0);
}

TEST(BulletMeshContacts, AnswerContactTestsOfCompounds) {
  MeshWorld w;
  auto& part = w.keep(mesh_shape(cube(0.5)));
  auto compound = std::make_unique<btCompoundShape>();
  compound->addChildShape(btTransform(btQuaternion::getIdentity(), {-3, 0, 0}), &part);
  compound->addChildShape(btTransform(btQuaternion::getIdentity(), {3, 0, 0}), &part);
  auto& both = w.keep(std::move(compound));
  btRigidBody &a = w.add(both, {0, 0, 0}), &b = w.add(both, {6.1F, 0.2F, 0.99F}),
              &c = w.add(part, {-3.2F, 0.1F, -0.99F});
  for (const btScalar threshold : {0.F, 0.1F}) {
    Tested ab, ac;
    ab.m_closestDistanceThreshold = ac.m_closestDistanceThreshold = threshold;
    w.world.contactPairTest(&a, &b, ab);
    EXPECT_GE(ab.points.size(), 4U);
    w.world.contactPairTest(&a, &c, ac);
    ASSERT_GE(ac.points.size(), 4U);
    for (const btManifoldPoint& point : ac.points) EXPECT_NEAR(point.getDistance(), -0.01, 1e-5);
  }
}

int calls = 0;

bool soften(btManifoldPoint& point, const btCollisionObjectWrapper* a, int, int, const btCollisionObjectWrapper* b, int,
            int) {
  ++calls;
  EXPECT_NE(a->getCollisionObject(), b->getCollisionObject());
  point.m_combinedFriction = 0.125F;
  return true;
}

TEST(BulletMeshContacts, HonourMaterialsAndCallbacks) {
  MeshWorld w;
  auto& shape = w.keep(mesh_shape(cube(0.5)));
  btRigidBody &a = w.add(shape, {0, 0, 0}), &b = w.add(shape, {0.2F, 0.1F, 0.99F});
  a.setFriction(0.5F);
  b.setFriction(0.3F);
  a.setRestitution(0.5F);
  b.setRestitution(0.4F);
  b.setContactStiffnessAndDamping(1000, 10);
  w.world.performDiscreteCollisionDetection();
  ASSERT_FALSE(w.points().empty());
  for (const btManifoldPoint& point : w.points()) {
    EXPECT_FLOAT_EQ(point.m_combinedFriction, 0.15F);
    EXPECT_FLOAT_EQ(point.m_combinedRestitution, 0.2F);
    EXPECT_TRUE(point.m_contactPointFlags & BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING);
    EXPECT_LT(std::abs(point.m_lateralFrictionDir1.dot(point.m_normalWorldOnB)), 1e-6);
  }
  gContactAddedCallback = soften;
  w.world.performDiscreteCollisionDetection();
  EXPECT_EQ(calls, 0);
  a.setCollisionFlags(a.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
  w.world.performDiscreteCollisionDetection();
  gContactAddedCallback = nullptr;
  EXPECT_EQ(calls, static_cast<int>(w.points().size()));
  for (const btManifoldPoint& point : w.points()) EXPECT_FLOAT_EQ(point.m_combinedFriction, 0.125F);
}

int started = 0, ended = 0;

TEST(BulletMeshContacts, TellWhenContactsBeginAndEnd) {
  MeshWorld w;
  auto& shape = w.keep(mesh_shape(cube(0.5)));
  w.add(shape, {0, 0, 0}, 0);
  btRigidBody& b = w.add(shape, {0.2F, 0.1F, 1.002F});
  started = ended = 0;
  gContactStartedCallback = [](btPersistentManifold* const&) { ++started; };
  gContactEndedCallback = [](btPersistentManifold* const&) { ++ended; };
  for (int i = 0; i < 5; ++i) w.world.performDiscreteCollisionDetection();
  EXPECT_EQ(started, 1);
  EXPECT_EQ(ended, 0);
  b.getWorldTransform().setOrigin({0.2F, 0.1F, 1.05F});
  for (int i = 0; i < 5; ++i) w.world.performDiscreteCollisionDetection();
  EXPECT_EQ(started, 1);
  EXPECT_EQ(ended, 1);
  gContactStartedCallback = nullptr;
  gContactEndedCallback = nullptr;
}

TEST(BulletMeshContacts, NoticeAChangeOfScalingOrMargin) {
  MeshWorld w;
  w.add(w.keep(mesh_shape(box({-9, -9, -1}, {9, 9, 0}))), {0, 0, 0}, 0);
  auto& shape = w.keep(std::make_unique<btBoxShape>(btVector3(1, 1, 0.5F)));
  btRigidBody& body = w.add(shape, {0, 0, 0.5F});
  body.setActivationState(DISABLE_DEACTIVATION);
  w.run(1);
  EXPECT_NEAR(body.getWorldTransform().getOrigin().z(), 0.5, 0.005);
  shape.setLocalScaling({2, 1, 3});
  body.getWorldTransform().setOrigin({0, 0, 1.6F});
  w.run(1.5);
  EXPECT_NEAR(body.getWorldTransform().getOrigin().z(), 1.5, 0.005);
  EXPECT_TRUE(w.contacts->forget(shape));
  EXPECT_FALSE(w.contacts->forget(shape));
  w.run(0.5);
  EXPECT_NEAR(body.getWorldTransform().getOrigin().z(), 1.5, 0.005);
}

TEST(BulletMeshContacts, MayGoBeforeTheWorldDoes) {
  MeshWorld w;
  auto& shape = w.keep(mesh_shape(cube(0.5)));
  w.add(shape, {0, 0, 0}, 0);
  btRigidBody& b = w.add(shape, {0, 0, 1.01F});
  w.run(0.2);
  EXPECT_GE(w.points().size(), 4U);
  w.contacts.reset();
  w.run(1);  // the pair keeps its algorithm
  EXPECT_NEAR(b.getWorldTransform().getOrigin().z(), 1, 0.005);
}

TEST(BulletMeshContacts, GiveTheDispatcherBackItsAlgorithms) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  struct Create : btCollisionAlgorithmCreateFunc {
    int asked = 0;
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo&,
                                                   const btCollisionObjectWrapper*,
                                                   const btCollisionObjectWrapper*) override {
      ++asked;
      return nullptr;
    }
  } create;
  dispatcher.registerCollisionCreateFunc(CUSTOM_CONCAVE_SHAPE_TYPE, BOX_SHAPE_PROXYTYPE, &create);
  const auto mesh = mesh_shape(cube(1));
  btBoxShape box(btVector3(1, 1, 1));
  btCollisionObject a, b;
  a.setCollisionShape(mesh.get());
  b.setCollisionShape(&box);
  const btTransform at = btTransform::getIdentity();
  const btCollisionObjectWrapper wrap_a(nullptr, mesh.get(), &a, at, -1, -1), wrap_b(nullptr, &box, &b, at, -1, -1);
  {
    BulletMeshContacts contacts(dispatcher);
    btCollisionAlgorithm* const algorithm =
        dispatcher.findAlgorithm(&wrap_a, &wrap_b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    EXPECT_EQ(create.asked, 0);
    ASSERT_NE(algorithm, nullptr);
    algorithm->~btCollisionAlgorithm();
    dispatcher.freeCollisionAlgorithm(algorithm);
  }
  EXPECT_EQ(dispatcher.findAlgorithm(&wrap_a, &wrap_b, nullptr, BT_CONTACT_POINT_ALGORITHMS), nullptr);
  EXPECT_EQ(create.asked, 1);
}

TEST(BulletMeshContacts, RefuseOptionsOutOfRange) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  EXPECT_THROW(BulletMeshContacts(dispatcher, {.skin = -1}), Error);
  EXPECT_THROW(BulletMeshContacts(dispatcher, {.most_speculation = std::nan("")}), Error);
  EXPECT_THROW(BulletMeshContacts(dispatcher, {.most_points = 0}), Error);
  EXPECT_THROW(BulletMeshContacts(dispatcher, {.most_per_patch = 100}), Error);
}

}  // namespace
}  // namespace encage::test
