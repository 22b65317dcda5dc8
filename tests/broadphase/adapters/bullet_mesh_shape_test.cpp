// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/adapters/bullet_mesh_world.h"
#include "tests/broadphase/adapters/bullet_world.h"

#include <encage/asset.h>
#include <encage/primitives.h>

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <string>

namespace encage::test {
namespace {

using shapes::box;
using shapes::cube;

Eigen::Vector3d numbers(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

std::string error_of(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(BulletMeshShape, HasTheInertiaOfABox) {
  const auto shape = mesh_shape(box({1, 2, 3}, {3, 5, 7}));
  const MassProperties mass = shape->mass_properties();
  EXPECT_NEAR(mass.mass, 24, 1e-12);
  EXPECT_LT((mass.centre - Eigen::Vector3d(2, 3.5, 5)).norm(), 1e-12);
  btVector3 inertia;
  shape->calculateLocalInertia(12, inertia);
  EXPECT_LT((numbers(inertia) - Eigen::Vector3d(9 + 16, 4 + 16, 4 + 9)).norm(), 1e-5);
}

TEST(BulletMeshShape, ScalesItsMassProperties) {
  const auto shape = mesh_shape(shapes::tetrahedron(1));
  shape->setLocalScaling({2, 2, 2});
  const MassProperties mass = shape->mass_properties();
  EXPECT_NEAR(mass.mass, 8.0 / 6, 1e-12);
  EXPECT_LT((mass.centre - Eigen::Vector3d::Constant(0.5)).norm(), 1e-12);
  EXPECT_NEAR(mass.inertia(0, 0), 32.0 / 80, 1e-12);
  EXPECT_NEAR(mass.inertia(0, 1), 32.0 / 480, 1e-12);
  EXPECT_NEAR(mass.moments[2], 32 * (1.0 / 80 + 2.0 / 480), 1e-12);
  btVector3 inertia;
  shape->calculateLocalInertia(1, inertia);
  EXPECT_NEAR(inertia.x(), 32.0 / 80 / (8.0 / 6), 1e-6);
}

TEST(BulletMeshShape, LiesInItsPrincipalFrameOnRequest) {
  const ShapePtr asset = make_shape(box({1, 2, 3}, {3, 5, 7}));
  BulletMeshShape shape(asset, {.frame = BulletFrame::principal, .reach = 0});
  EXPECT_LT((shape.asset_to_body() * Eigen::Vector3d(2, 3.5, 5)).norm(), 1e-12);
  btVector3 inertia, low, high;
  shape.calculateLocalInertia(12, inertia);
  EXPECT_LT((numbers(inertia) - Eigen::Vector3d(13, 20, 25)).norm(), 1e-5);  // ascending
  shape.getAabb(btTransform::getIdentity(), low, high);
  EXPECT_LT((numbers(high) - Eigen::Vector3d(2, 1.5, 1)).norm(), 1e-4);
  EXPECT_LT((numbers(low) + Eigen::Vector3d(2, 1.5, 1)).norm(), 1e-4);
  EXPECT_NEAR(shape.radius(), std::sqrt(4 + 2.25 + 1), 1e-12);
}

TEST(BulletMeshShape, TakesTheInertiaOfItsBoxWhereItEnclosesNothing) {
  TriangleMesh open = cube(1);
  open.triangles.conservativeResize(11, 3);
  const auto shape = mesh_shape(open);
  btVector3 inertia;
  shape->calculateLocalInertia(3, inertia);
  EXPECT_LT((numbers(inertia) - Eigen::Vector3d(2, 2, 2)).norm(), 1e-6);
  EXPECT_NE(error_of([&] { shape->mass_properties(); }).find("encloses no volume"), std::string::npos);
  EXPECT_THROW(BulletMeshShape(shape->shape(), {.frame = BulletFrame::principal}), Error);
}

TEST(BulletMeshShape, HasATightBoxInEveryPose) {
  const TriangleMesh mesh = shapes::torus(2, 0.5, 24, 12);
  const auto shape = mesh_shape(mesh);
  shape->setLocalScaling({3, 3, 3});
  shape->setMargin(0.25F);
  std::minstd_rand random(1);
  std::uniform_real_distribution<float> number(-1, 1);
  for (int i = 0; i < 100; ++i) {
    btQuaternion turn(number(random), number(random), number(random), number(random));
    const btTransform at(turn.normalized(), {number(random), number(random), number(random)});
    btVector3 low, high;
    shape->getAabb(at, low, high);
    Eigen::AlignedBox3d exact;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
      const Eigen::Vector3d x = 3 * mesh.vertices.row(v).transpose();
      exact.extend(
          numbers(at * btVector3(static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z()))));
    }
    EXPECT_LT((numbers(low) - exact.min()).maxCoeff(), -0.25 - 0.02 * 7.5 + 1e-5);
    EXPECT_GT((numbers(high) - exact.max()).minCoeff(), 0.25 + 0.02 * 7.5 - 1e-5);
    EXPECT_LT((exact.min() - numbers(low)).maxCoeff(), 1.5);  // of a body of radius 7.5
    EXPECT_LT((numbers(high) - exact.max()).maxCoeff(), 1.5);
  }
}

TEST(BulletMeshShape, RefusesWhatItCannotBe) {
  EXPECT_NE(error_of([] { BulletMeshShape shape(nullptr); }).find("null"), std::string::npos);
  EXPECT_NE(error_of([] { BulletMeshShape shape(make_sphere(2)); }).find("convex radius of 2"), std::string::npos);
  EXPECT_THROW(BulletMeshShape(make_shape(cube(1)), {.reach = -1}), Error);
  const auto shape = mesh_shape(cube(1));
  EXPECT_NE(error_of([&] { shape->setLocalScaling({1, 1, 2}); }).find("(1 1 2)"), std::string::npos);
  EXPECT_THROW(shape->setLocalScaling({0, 0, 0}), Error);
  EXPECT_THROW(shape->setLocalScaling({-1, -1, -1}), Error);
  EXPECT_EQ(shape->getLocalScaling(), btVector3(1, 1, 1));
  CageHierarchy cages = body_named("torus").sample.hierarchy;
  cages.fine = {};
  cages.cap_count = 0;
  const ShapePtr without = make_shape(cages);
  EXPECT_NE(error_of([&] { BulletMeshShape s(without); }).find("no fine mesh"), std::string::npos);
  const std::array<CompoundPart, 2> parts = {CompoundPart{make_shape(cube(1))}, CompoundPart{without}};
  EXPECT_NE(error_of([&] { BulletMeshShape s(make_compound(parts)); }).find("part 1"), std::string::npos);
}

TEST(BulletMeshShape, IsMadeOnlyFromTheAssetOfTheMesh) {
  const std::string file = ENCAGE_TEST_DATA "/asset_v1.glb";
  const CageHierarchy asset = read_asset(file);
  TriangleMesh source = asset.fine;
  source.vertices.rowwise() += asset.origin.transpose();
  source.triangles.conservativeResize(source.triangles.rows() - asset.cap_count, 3);
  const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> vertices = source.vertices.cast<float>();
  btTriangleIndexVertexArray arrays(static_cast<int>(source.triangles.rows()), source.triangles.data(), 12,
                                    static_cast<int>(vertices.rows()), const_cast<float*>(vertices.data()), 12);
  EXPECT_EQ(error_of([&] { BulletMeshShape shape(file, source); }), "");
  EXPECT_EQ(error_of([&] { BulletMeshShape shape(file, arrays); }), "");
  const std::string refusal = error_of([&] { BulletMeshShape shape(file, cube(1)); });
  EXPECT_NE(refusal.find(file), std::string::npos) << refusal;
  EXPECT_NE(refusal.find("was not baked from this mesh"), std::string::npos) << refusal;
}

/// The triangles that a callback gets.
struct Collected : btTriangleCallback {
  void processTriangle(btVector3* triangle, int part, int index) override {
    EXPECT_EQ(part, 0);
    EXPECT_TRUE(indices.insert(index).second);
    corners.push_back({triangle[0], triangle[1], triangle[2]});
  }
  std::set<int> indices;
  std::vector<std::array<btVector3, 3>> corners;
};

TEST(BulletMeshShape, PassesTheTrianglesNearABox) {
  const TriangleMesh mesh = shapes::torus(2, 0.5, 40, 20);
  const auto shape = mesh_shape(mesh);
  Collected all, some;
  shape->processAllTriangles(&all, btVector3(-1e18F, -1e18F, -1e18F), btVector3(1e18F, 1e18F, 1e18F));
  EXPECT_EQ(all.indices.size(), static_cast<std::size_t>(mesh.triangles.rows()));
  const btVector3 low(1, 1, -1), high(2, 2, 0);
  shape->processAllTriangles(&some, low, high);
  EXPECT_LT(some.indices.size(), all.indices.size() / 4);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    Eigen::AlignedBox3d bounds;
    for (int k = 0; k < 3; ++k) bounds.extend(mesh.corner(t, k));
    if (!bounds.intersects(Eigen::AlignedBox3d(numbers(low), numbers(high)))) continue;
    EXPECT_TRUE(some.indices.count(static_cast<int>(t))) << t;
  }
}

TEST(BulletMeshShape, IsHitByRaysWhereItsTrianglesAre) {
  const TriangleMesh mesh = shapes::sphere(4);
  MeshWorld w;
  auto& shape = w.keep(mesh_shape(mesh));
  shape.setLocalScaling({2, 2, 2});
  w.add(shape, {5, 0, 0}, 0);
  std::minstd_rand random(3);
  std::uniform_real_distribution<float> number(-1, 1);
  for (int i = 0; i < 500; ++i) {
    const btVector3 inside(5 + 0.4F * number(random), 0.4F * number(random), 0.4F * number(random));
    const btVector3 outside = inside + 9 * btVector3(number(random), number(random), number(random)).normalized();
    btCollisionWorld::ClosestRayResultCallback hit(outside, inside);
    w.world.rayTest(outside, inside, hit);
    ASSERT_TRUE(hit.hasHit());
    // Between the circles in and around the triangles; the normal faces the ray.
    const double distance = numbers(hit.m_hitPointWorld - btVector3(5, 0, 0)).norm();
    EXPECT_LE(distance, 2 + 1e-4);
    EXPECT_GE(distance, 2 * 0.99);
    EXPECT_GT(hit.m_hitNormalWorld.dot((hit.m_hitPointWorld - btVector3(5, 0, 0)).normalized()), 0.98F);
    btCollisionWorld::ClosestRayResultCallback miss(outside, outside + (outside - inside));
    w.world.rayTest(outside, outside + (outside - inside), miss);
    EXPECT_FALSE(miss.hasHit());
  }
}

TEST(BulletMeshShape, TellsTheTriangleThatARayHits) {
  const TriangleMesh a = cube(1), b = shapes::tetrahedron(1);
  const std::array<CompoundPart, 2> parts = {
      CompoundPart{make_shape(a)}, CompoundPart{make_shape(b), Eigen::Isometry3d(Eigen::Translation3d(10, 0, 0)), 3}};
  MeshWorld w;
  w.add(w.keep(std::make_unique<BulletMeshShape>(make_compound(parts))), {0, 0, 0}, 0);
  struct Closest : btCollisionWorld::ClosestRayResultCallback {
    using ClosestRayResultCallback::ClosestRayResultCallback;
    btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool world) override {
      triangle = result.m_localShapeInfo->m_triangleIndex;
      return ClosestRayResultCallback::addSingleResult(result, world);
    }
    int triangle = -1;
  };
  const btVector3 from(10.5F, 0.6F, 9), to(10.5F, 0.6F, -9);
  Closest up(to, from), down(from, to);
  w.world.rayTest(to, from, up);
  EXPECT_EQ(up.triangle, 12);  // the first of the second part, in the plane z = 0
  EXPECT_NEAR(up.m_hitPointWorld.z(), 0, 1e-5);
  w.world.rayTest(from, to, down);
  EXPECT_EQ(down.triangle, 14);  // x + y + z = 3
  EXPECT_NEAR(down.m_hitPointWorld.z(), 3 - 0.5 - 0.6, 1e-5);
}

// Small triangles far from where the ray begins: Bullet's own test in float falls between them.
TEST(BulletMeshShape, LetsNoRayPassBetweenItsTriangles) {
  const TriangleMesh mesh = shapes::sphere(5);
  MeshWorld w;
  w.add(w.keep(mesh_shape(mesh)), {0, 0, 0}, 0);
  std::minstd_rand random(5);
  std::uniform_real_distribution<float> number(-1, 1);
  for (int i = 0; i < 2'000; ++i) {
    // Through a vertex, or a point of an edge, in the middle of the sphere as seen.
    const Eigen::Index t = static_cast<Eigen::Index>(random() % static_cast<unsigned>(mesh.triangles.rows()));
    const double part = i % 2 == 0 ? 0 : 0.5 + 0.5 * static_cast<double>(number(random));
    const Eigen::Vector3d target = (1 - part) * mesh.corner(t, 0) + part * mesh.corner(t, 1);
    const btVector3 at(static_cast<float>(target.x()), static_cast<float>(target.y()), static_cast<float>(target.z()));
    const btVector3 outside = 3'000 * at.normalized();
    btCollisionWorld::ClosestRayResultCallback hit(outside, -outside);
    w.world.rayTest(outside, -outside, hit);
    ASSERT_TRUE(hit.hasHit()) << i;
    EXPECT_NEAR(hit.m_closestHitFraction, 0.5 - 0.5 / 3'000, 1e-5);
  }
}

TEST(BulletMeshShape, RaysKeepBulletsFlagsAndFindAllHits) {
  const TriangleMesh mesh = shapes::torus(1, 0.35, 24, 12);
  MeshWorld w;
  w.add(w.keep(mesh_shape(mesh)), {0, 0, 0}, 0);
  const btVector3 from(-5, 0.03F, 0.02F), to(5, 0.03F, 0.02F);  // through the ring: four sides
  btCollisionWorld::AllHitsRayResultCallback all(from, to);
  w.world.rayTest(from, to, all);
  ASSERT_EQ(all.m_hitFractions.size(), 4);
  std::array<float, 4> fractions{};
  for (int i = 0; i < 4; ++i) {
    fractions[static_cast<std::size_t>(i)] = static_cast<float>(all.m_hitFractions[i]);
    EXPECT_LT(all.m_hitNormalWorld[i].x(), 0) << "faces the ray";
  }
  std::sort(fractions.begin(), fractions.end());
  EXPECT_NEAR(fractions[0], 0.365, 2e-3);
  EXPECT_NEAR(fractions[1], 0.435, 2e-3);
  EXPECT_NEAR(fractions[2], 0.565, 2e-3);
  EXPECT_NEAR(fractions[3], 0.635, 2e-3);
  btCollisionWorld::AllHitsRayResultCallback front(from, to), kept(from, to);
  front.m_flags = btTriangleRaycastCallback::kF_FilterBackfaces;
  w.world.rayTest(from, to, front);
  EXPECT_EQ(front.m_hitFractions.size(), 2);
  kept.m_flags = btTriangleRaycastCallback::kF_KeepUnflippedNormal;
  w.world.rayTest(from, to, kept);
  ASSERT_EQ(kept.m_hitNormalWorld.size(), 4);
  int along = 0;
  for (int i = 0; i < 4; ++i) along += kept.m_hitNormalWorld[i].x() > 0;
  EXPECT_EQ(along, 2);
}

/// All triangles of another shape, whatever the box: brute force for sweeps.
class EveryTriangle final : public btConcaveShape {
 public:
  explicit EveryTriangle(const BulletMeshShape& of) : of_(of) { m_shapeType = CUSTOM_CONCAVE_SHAPE_TYPE; }
  void processAllTriangles(btTriangleCallback* callback, const btVector3&, const btVector3&) const override {
    of_.processAllTriangles(callback, btVector3(-1e18F, -1e18F, -1e18F), btVector3(1e18F, 1e18F, 1e18F));
  }
  void getAabb(const btTransform& body, btVector3& low, btVector3& high) const override {
    of_.getAabb(body, low, high);
  }
  void setLocalScaling(const btVector3&) override {}
  const btVector3& getLocalScaling() const override { return of_.getLocalScaling(); }
  void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
  const char* getName() const override { return "every triangle"; }

 private:
  const BulletMeshShape& of_;
};

TEST(BulletMeshShape, IsHitBySweepsWhereBruteForceIs) {
  MeshWorld w, all;
  auto& shape = w.keep(mesh_shape(shapes::torus(1, 0.35, 32, 16)));
  shape.setLocalScaling({1.5F, 1.5F, 1.5F});
  auto& every = all.keep(std::make_unique<EveryTriangle>(shape));
  every.setMargin(shape.getMargin());
  const btVector3 place(3, -2, 1);
  w.add(shape, place, 0).getWorldTransform().setRotation(btQuaternion(btVector3(1, 2, 3).normalized(), 0.7F));
  all.add(every, place, 0).getWorldTransform().setRotation(btQuaternion(btVector3(1, 2, 3).normalized(), 0.7F));
  w.world.updateAabbs();
  all.world.updateAabbs();
  std::minstd_rand random(6);
  std::uniform_real_distribution<float> number(-1, 1);
  const btSphereShape sphere(0.2F);
  const btBoxShape cuboid(btVector3(0.1F, 0.3F, 0.2F));
  const btCapsuleShape capsule(0.15F, 0.5F);
  int hits = 0, misses = 0;
  for (int i = 0; i < 300; ++i) {
    const btConvexShape& cast = i % 3 == 0   ? static_cast<const btConvexShape&>(sphere)
                                : i % 3 == 1 ? static_cast<const btConvexShape&>(cuboid)
                                             : static_cast<const btConvexShape&>(capsule);
    const auto point = [&](float size) {
      return place + size * btVector3(number(random), number(random), number(random));
    };
    btTransform from, to;
    from.setIdentity();
    from.setRotation(btQuaternion(number(random), number(random), number(random)));
    to = from;
    from.setOrigin(point(6));
    to.setOrigin(point(3));
    btCollisionWorld::ClosestConvexResultCallback found(from.getOrigin(), to.getOrigin()),
        expected(from.getOrigin(), to.getOrigin());
    w.world.convexSweepTest(&cast, from, to, found);
    all.world.convexSweepTest(&cast, from, to, expected);
    ASSERT_EQ(found.hasHit(), expected.hasHit()) << i;
    if (expected.hasHit()) {
      ++hits;
      EXPECT_EQ(found.m_closestHitFraction, expected.m_closestHitFraction) << i;
    } else {
      ++misses;
    }
  }
  EXPECT_GT(hits, 50);
  EXPECT_GT(misses, 50);
}

}  // namespace
}  // namespace encage::test
