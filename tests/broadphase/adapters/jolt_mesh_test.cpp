// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/adapters/jolt_world.h"

#include <encage/asset.h>

#include <Jolt/Physics/Collision/CastResult.h>
#include <Jolt/Physics/Collision/NarrowPhaseQuery.h>
#include <Jolt/Physics/Collision/RayCast.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace encage::test {
namespace {

using shapes::box;
using shapes::cube;
using shapes::moved;

const std::filesystem::path golden = std::filesystem::path(ENCAGE_TEST_DATA) / "asset_v1.glb";

template <class F>
std::string error_of(const F& f) {
  try {
    f();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

class JoltMeshTest : public testing::Test {
 protected:
  JoltMeshTest() { register_jolt(); }
};

TEST_F(JoltMeshTest, HasTheMassPropertiesOfTheSolid) {
  const JoltMesh mesh(box({1, 2, 3}, {2, 4, 6}));
  EXPECT_TRUE(mesh.encloses_volume());
  const JPH::MassProperties mass = mesh.mass_properties(10);
  EXPECT_FLOAT_EQ(mass.mMass, 60);
  EXPECT_FLOAT_EQ(mass.mInertia(0, 0), 60 / 12.F * (4 + 9));
  EXPECT_FLOAT_EQ(mass.mInertia(1, 1), 60 / 12.F * (1 + 9));
  EXPECT_FLOAT_EQ(mass.mInertia(2, 2), 60 / 12.F * (1 + 4));
  EXPECT_NEAR(mass.mInertia(0, 1), 0, 1e-4);
  EXPECT_FLOAT_EQ(mass.mInertia(3, 3), 1);

  const JPH::MassProperties twice = mesh.mass_properties(10, 2);
  EXPECT_FLOAT_EQ(twice.mMass, 480);
  EXPECT_FLOAT_EQ(twice.mInertia(0, 0), 32 * mass.mInertia(0, 0));
}

TEST_F(JoltMeshTest, BodiesTurnAboutTheCentreOfMassAndAreWhereTheirFrameIs) {
  JoltWorld world;
  world.system.SetGravity(JPH::Vec3::sZero());
  const JoltMesh mesh(box({1, 2, 3}, {2, 4, 6}));
  const JPH::BodyID id = world.add(mesh, {10, 0, 0}, 2);
  EXPECT_TRUE(world.bodies().GetPosition(id).IsClose(JPH::RVec3(10, 0, 0)));
  EXPECT_TRUE(world.bodies().GetCenterOfMassPosition(id).IsClose(JPH::RVec3(11.5F, 3, 4.5F)));
  const JPH::AABox bounds = world.bodies().GetTransformedShape(id).GetWorldSpaceBounds();
  EXPECT_TRUE(bounds.mMin.IsClose({11, 2, 3}, 1e-6F));
  EXPECT_TRUE(bounds.mMax.IsClose({12, 4, 6}, 1e-6F));
  world.bodies().SetAngularVelocity(id, {0, 0, 1});
  world.run(1);
  EXPECT_TRUE(world.bodies().GetCenterOfMassPosition(id).IsClose(JPH::RVec3(11.5F, 3, 4.5F), 1e-6F));
}

TEST_F(JoltMeshTest, RaysFindTheTriangleOfTheSource) {
  const TriangleMesh source = shapes::torus(1, 0.3, 24, 12);
  const JoltMesh mesh(source);
  JoltWorld world;
  world.add(mesh, {5, 0, 0});
  for (std::int32_t t = 0; t < source.triangles.rows(); t += 7) {
    const Eigen::Vector3d a = source.corner(t, 0), b = source.corner(t, 1), c = source.corner(t, 2);
    const Eigen::Vector3d middle = (a + b + c) / 3 + Eigen::Vector3d(5, 0, 0),
                          normal = (b - a).cross(c - a).normalized();
    const JPH::RRayCast ray(JPH::RVec3(jolt::to_jolt(middle + 0.1 * normal)), jolt::to_jolt(-0.2 * normal));
    JPH::RayCastResult hit;
    ASSERT_TRUE(world.system.GetNarrowPhaseQuery().CastRay(ray, hit)) << t;
    EXPECT_NEAR(hit.mFraction, 0.5, 1e-3) << t;
    EXPECT_EQ(mesh.triangle(hit.mSubShapeID2), t);
  }
}

TEST_F(JoltMeshTest, SubmersionIsThatOfTheSolid) {
  JoltWorld world;
  const JoltMesh mesh(moved(cube(1), {0, 0, 5}));
  const JPH::BodyID id = world.add(mesh, {100, 0, -5});
  const JPH::BodyLockRead lock(world.system.GetBodyLockInterface(), id);
  const JPH::Body& body = lock.GetBody();
  const JPH::Vec3 up(0, 0, 1);
  const JoltSubmersion part = mesh.submersion(body, JPH::RVec3(0, 0, -0.5F), up);
  EXPECT_FLOAT_EQ(part.total_volume, 8);
  EXPECT_NEAR(part.submerged_volume, 2, 1e-4);
  EXPECT_TRUE(part.relative_centre.IsClose({0, 0, -0.75F}, 1e-6F));
  EXPECT_NEAR(mesh.submersion(body, JPH::RVec3(0, 0, 3), up).submerged_volume, 8, 1e-4);
  EXPECT_NEAR(mesh.submersion(body, JPH::RVec3(0, 0, -3), up).submerged_volume, 0, 1e-4);
  // A corner: the simplex whose edges are 1 long.
  const double offset = -2 / std::sqrt(3.0);
  const JPH::Vec3 diagonal = JPH::Vec3(1, 1, 1).Normalized();
  const JoltSubmersion corner =
      mesh.submersion(body, body.GetCenterOfMassPosition() + static_cast<float>(offset) * diagonal, diagonal);
  EXPECT_NEAR(corner.submerged_volume, 1 / 6.0, 1e-4);
  EXPECT_TRUE(corner.relative_centre.IsClose(JPH::Vec3::sReplicate(-0.75F), 1e-5F));
}

TEST_F(JoltMeshTest, AssetsHaveTheFrameOfTheirSource) {
  const JoltMesh mesh(golden);
  const CageHierarchy hierarchy = read_asset(golden);
  const Eigen::AlignedBox3d expected = bounds(hierarchy.fine);
  const JPH::AABox box = mesh.mesh_shape().GetLocalBounds();
  EXPECT_LT((jolt::to_eigen(box.mMin) - hierarchy.origin - expected.min()).norm(), 1e-3 * mesh.radius());
  EXPECT_LT((jolt::to_eigen(box.mMax) - hierarchy.origin - expected.max()).norm(), 1e-3 * mesh.radius());
}

TEST_F(JoltMeshTest, RefusesWhatIsNoMeshOfTheShape) {
  EXPECT_EQ(error_of([] { JoltMesh(nullptr, cube(1)); }), "Jolt mesh: the shape is null");
  EXPECT_EQ(error_of([] { JoltMesh(make_shape(cube(1)), cube(2)); }),
            "Jolt mesh: the mesh is not within the box of the shape, and so is not its own");
  EXPECT_NE(error_of([] { JoltMesh("no_such.glb"); }).find("no_such.glb"), std::string::npos);
}

TEST_F(JoltMeshTest, SurfacesHaveNoMass) {
  const JoltMesh mesh(shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
  EXPECT_FALSE(mesh.encloses_volume());
  EXPECT_EQ(error_of([&] { mesh.mass_properties(1); }), "Jolt mesh: mass properties: the mesh encloses no volume");
  EXPECT_EQ(error_of([&] { mesh.body_settings(JPH::RVec3::sZero(), JPH::Quat::sIdentity(), 0, 1); }),
            "Jolt mesh: mass properties: the mesh encloses no volume");
}

}  // namespace
}  // namespace encage::test
