// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/adapters/jolt_world.h"

#include <Jolt/Physics/Collision/Shape/HeightFieldShape.h>
#include <Jolt/Physics/Collision/Shape/RotatedTranslatedShape.h>
#include <Jolt/Physics/Collision/Shape/ScaledShape.h>
#include <Jolt/Physics/Collision/Shape/StaticCompoundShape.h>
#include <Jolt/Physics/Collision/Shape/TaperedCapsuleShape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <ostream>
#include <string>

namespace encage::test {
namespace {

using shapes::box;
using shapes::cube;

class JoltContactsTest : public testing::Test {
 protected:
  JoltContactsTest() { register_jolt(); }
};

/// A tray: a cube with a hollow that is open at the top, 1.6 wide and 0.9 deep; its floor is at z = 0.1.
TriangleMesh tray() {
  TriangleMesh outer = box({-1, -1, 0}, {1, 1, 1});
  const TriangleMesh hollow = shapes::flipped(box({-0.8, -0.8, 0.1}, {0.8, 0.8, 1}));
  // The top of the outer box and that of the hollow become a ring.
  const auto without_top = [](TriangleMesh mesh) {
    Triangles kept(0, 3);
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      bool is_top = true;
      for (int k = 0; k < 3; ++k) is_top &= mesh.corner(t, k).z() == 1;
      if (is_top) continue;
      kept.conservativeResize(kept.rows() + 1, 3);
      kept.row(kept.rows() - 1) = mesh.triangles.row(t);
    }
    mesh.triangles = kept;
    return mesh;
  };
  TriangleMesh mesh = shapes::joined(without_top(outer), without_top(hollow));
  const auto vertex_at = [&](double x, double y) {
    for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
      if (mesh.vertex(v) == Eigen::Vector3d(x, y, 1)) return v;
    }
    return std::int32_t{-1};
  };
  constexpr std::array<std::array<int, 2>, 4> corners = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [x, y] = corners[i];
    const auto [u, v] = corners[(i + 1) % 4];
    const std::int32_t a = vertex_at(x, y), b = vertex_at(u, v), c = vertex_at(0.8 * u, 0.8 * v),
                       d = vertex_at(0.8 * x, 0.8 * y);
    const Eigen::Index rows = mesh.triangles.rows();
    mesh.triangles.conservativeResize(rows + 2, 3);
    mesh.triangles.row(rows) << a, b, c;
    mesh.triangles.row(rows + 1) << a, c, d;
  }
  return mesh;
}

TEST_F(JoltContactsTest, TheTrayIsClosed) {
  EXPECT_TRUE(is_closed(tray()));
  EXPECT_NEAR(signed_volume(tray()), 4 - 1.6 * 1.6 * 0.9, 1e-12);
}

struct Partner {
  std::string name;
  std::function<JPH::Ref<JPH::Shape>()> make;
  double top;  ///< highest point
};

void PrintTo(const Partner& partner, std::ostream* out) { *out << partner.name; }

class JoltPartners : public testing::TestWithParam<Partner> {
 protected:
  JoltPartners() { register_jolt(); }
};

/// The tray, upside down, holds what it is put over, or stands on it.
TEST_P(JoltPartners, CarryATray) {
  JoltWorld world;
  world.add_static(GetParam().make());
  TriangleMesh mesh = tray();
  mesh.vertices.col(2) *= -1;
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  const JPH::BodyID id = world.add(JoltMesh(mesh), {0, 0, GetParam().top + 0.2});
  world.run(3);
  EXPECT_TRUE(world.contacts->take_errors().empty());
  EXPECT_NEAR(world.position(id).z(), GetParam().top + 0.1, 3e-3);
  EXPECT_LT(world.bodies().GetLinearVelocity(id).Length(), 0.02);
}

JPH::Ref<JPH::Shape> square_mesh(float half) {
  JPH::TriangleList triangles = {
      {JPH::Float3(-half, -half, 0), JPH::Float3(half, -half, 0), JPH::Float3(half, half, 0)},
      {JPH::Float3(-half, -half, 0), JPH::Float3(half, half, 0), JPH::Float3(-half, half, 0)}};
  return JPH::MeshShapeSettings(triangles).Create().Get();
}

template <class Settings, class... Arguments>
JPH::Ref<JPH::Shape> made(Arguments... arguments) {
  JPH::Ref<Settings> settings = new Settings(arguments...);
  return settings->Create().Get();
}

JPH::Ref<JPH::Shape> cube_hull() {
  JPH::Array<JPH::Vec3> points;
  for (int i = 0; i < 8; ++i) points.push_back({i & 1 ? .5F : -.5F, i & 2 ? .5F : -.5F, i & 4 ? 1.F : 0.F});
  return made<JPH::ConvexHullShapeSettings>(points, 0.01F);
}

JPH::Quat upright() { return JPH::Quat::sRotation(JPH::Vec3::sAxisX(), 0.5F * JPH::JPH_PI); }

// Those with a flat top carry the tray by the inner side of its bottom.
INSTANTIATE_TEST_SUITE_P(
    Shapes, JoltPartners,
    testing::Values(
        Partner{"Box", [] { return made<JPH::BoxShapeSettings>(JPH::Vec3(0.5F, 0.5F, 1)); }, 1},
        Partner{"ConvexHull", cube_hull, 1},
        Partner{"Cylinder",
                [] {
                  return made<JPH::RotatedTranslatedShapeSettings>(
                      JPH::Vec3::sZero(), upright(), made<JPH::CylinderShapeSettings>(1.F, 0.5F).GetPtr());
                },
                1},
        Partner{"TwoSpheres",
                [] {
                  JPH::StaticCompoundShapeSettings settings;
                  settings.SetEmbedded();
                  for (const JPH::Vec3 at : {JPH::Vec3(.5F, .5F, 0), JPH::Vec3(-.5F, .5F, 0), JPH::Vec3(0, -.5F, 0)}) {
                    settings.AddShape(at, JPH::Quat::sIdentity(), new JPH::SphereShape(0.2F));
                  }
                  return settings.Create().Get();
                },
                0.2},
        Partner{"Capsules",
                [] {
                  JPH::StaticCompoundShapeSettings settings;
                  settings.SetEmbedded();
                  for (const float x : {-0.4F, 0.4F}) {
                    settings.AddShape(JPH::Vec3(x, 0, 0), JPH::Quat::sIdentity(), new JPH::CapsuleShape(0.3F, 0.2F));
                  }
                  return settings.Create().Get();
                },
                0.2},
        Partner{"TaperedCapsules",
                [] {
                  JPH::StaticCompoundShapeSettings settings;
                  settings.SetEmbedded();
                  for (const JPH::Vec3 at : {JPH::Vec3(.5F, .5F, 0), JPH::Vec3(-.5F, .5F, 0), JPH::Vec3(0, -.5F, 0)}) {
                    settings.AddShape(at, upright(), made<JPH::TaperedCapsuleShapeSettings>(0.5F, 0.2F, 0.1F).GetPtr());
                  }
                  return settings.Create().Get();
                },
                0.7}),
    [](const auto& partner) { return partner.param.name; });

TEST_F(JoltContactsTest, MeshesRestOnSurfaces) {
  std::vector<float> heights(16, 0.F);
  const JPH::Ref<JPH::Shape> terrain =
      made<JPH::HeightFieldShapeSettings>(heights.data(), JPH::Vec3(-2, 0, -2), JPH::Vec3(1.3F, 1, 1.3F), 4U);
  const JPH::Ref<JPH::Shape> upright_terrain =
      made<JPH::RotatedTranslatedShapeSettings>(JPH::Vec3::sZero(), upright(), terrain.GetPtr());
  const JPH::Ref<JPH::Shape> plane = new JPH::PlaneShape(JPH::Plane(JPH::Vec3(0, 0, 1), 0), nullptr, 100);
  for (const JPH::Ref<JPH::Shape>& ground : {plane, square_mesh(3), upright_terrain}) {
    JoltWorld world;
    world.add_static(ground);
    const JoltMesh mesh(tray());
    const JPH::BodyID lower = world.add(mesh, {0, 0, 0.1});
    const JPH::BodyID inside = world.add(JoltMesh(cube(0.4)), {0.2, 0.1, 0.7});
    world.run(3);
    EXPECT_TRUE(world.contacts->take_errors().empty());
    const std::string name = jolt::name_of(*ground);
    EXPECT_NEAR(world.position(lower).z(), 0, 3e-3) << name;
    EXPECT_NEAR(world.position(inside).z(), 0.5, 5e-3) << name;
    EXPECT_FALSE(world.bodies().IsActive(inside)) << name;
  }
}

TEST_F(JoltContactsTest, OneManifoldPerFaceThatLastsAndHasItsPoints) {
  for (const bool reduces : {false, true}) {
    JoltWorld world;
    world.add_ground();
    world.system.SetContactListener(&world.manifolds);
    const JoltMesh mesh(cube(0.5));
    world.contacts->add(mesh);
    JPH::BodyCreationSettings settings = mesh.body_settings(JPH::RVec3(0, 0, 0.5F), JPH::Quat::sIdentity(), 0, 1);
    settings.mUseManifoldReduction = reduces;
    settings.mAllowSleeping = false;
    world.add(settings);
    world.run(2);
    ASSERT_EQ(world.manifolds.now.size(), 1U);
    const JPH::ContactManifold& manifold = world.manifolds.now[0];
    EXPECT_EQ(manifold.mRelativeContactPointsOn1.size(), 4U);
    EXPECT_NEAR(std::abs(manifold.mWorldSpaceNormal.GetZ()), 1, 1e-5);
    for (const JPH::Vec3 point : manifold.mRelativeContactPointsOn1) {
      EXPECT_NEAR(std::abs(point.GetX()), 0.5, 1e-3);
      EXPECT_NEAR(std::abs(point.GetY()), 0.5, 1e-3);
    }
    EXPECT_EQ(world.manifolds.added, 1);
  }
}

TEST_F(JoltContactsTest, LinksHangInEachOther) {
  const JoltMesh ring(shapes::torus(0.24, 0.07, 40, 16));
  JoltWorld world;
  world.contacts->add(ring);
  JPH::BodyCreationSettings top = ring.body_settings(JPH::RVec3::sZero(), upright(), 0, 1000);
  top.mMotionType = JPH::EMotionType::Static;
  world.add(top);
  const JPH::Quat across = JPH::Quat::sRotation(JPH::Vec3::sAxisZ(), 0.5F * JPH::JPH_PI) * upright();
  const JPH::BodyID lower = world.add(ring.body_settings(JPH::RVec3(0, 0, -0.335F), across, 0, 1000));
  world.run(5);
  // The distance of the centres: twice the inner radius.
  EXPECT_NEAR(world.position(lower).z(), -0.34, 5e-3);
  EXPECT_TRUE(world.contacts->take_errors().empty());
}

TEST_F(JoltContactsTest, FastBodiesDoNotEnterEachOther) {
  JoltWorld world;
  world.add_ground();
  const JPH::BodyID id = world.add(JoltMesh(cube(0.5)), {0, 0, 0.58});
  world.bodies().SetLinearVelocity(id, {0, 0, -20});
  // Within reach of Jolt's pairs, which it finds by boxes that are 2 cm larger.
  world.bodies().SetPosition(id, JPH::RVec3(0, 0, 0.515F), JPH::EActivation::Activate);
  world.run(1 / 60.0);
  EXPECT_GT(world.position(id).z(), 0.498);
}

TEST_F(JoltContactsTest, FreeBodiesKeepTheirMomentum) {
  JoltWorld world;
  world.system.SetGravity(JPH::Vec3::sZero());
  const JoltMesh ring(shapes::torus(1, 0.3, 32, 16));
  const auto add = [&](const Eigen::Vector3d& at, JPH::Vec3Arg velocity, JPH::Vec3Arg turn) {
    JPH::BodyCreationSettings settings =
        ring.body_settings(JPH::RVec3(jolt::to_jolt(at)), JPH::Quat::sIdentity(), 0, 1);
    settings.mLinearDamping = settings.mAngularDamping = 0;
    settings.mLinearVelocity = velocity;
    settings.mAngularVelocity = turn;
    world.contacts->add(ring);
    return world.add(settings);
  };
  const JPH::BodyID a = add({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), b = add({2.5, 0.3, 0.2}, {-1, 0, 0}, {1, 0, 0});
  const auto sum = [&] { return world.bodies().GetLinearVelocity(a) + world.bodies().GetLinearVelocity(b); };
  world.run(2);
  EXPECT_TRUE(sum().IsClose(JPH::Vec3::sZero(), 1e-6F));
  EXPECT_LT(world.bodies().GetLinearVelocity(a).GetX(), 0.9F);
}

TEST_F(JoltContactsTest, CompoundsAndScaledShapes) {
  const JoltMesh mesh(cube(0.5));
  JPH::StaticCompoundShapeSettings compound;
  compound.SetEmbedded();
  for (const float x : {-1.F, 1.F}) compound.AddShape({x, 0, 0}, JPH::Quat::sIdentity(), mesh.jolt_shape());
  compound.AddShape({0, 0, 0.2F}, JPH::Quat::sIdentity(), new JPH::BoxShape(JPH::Vec3(1, 0.3F, 0.1F)));
  const JPH::Ref<JPH::Shape> dumbbell = compound.Create().Get();
  const JPH::Ref<JPH::Shape> half = new JPH::ScaledShape(mesh.jolt_shape(), JPH::Vec3::sReplicate(0.5F));

  JoltWorld world;
  world.contacts->add(mesh);
  world.add_ground();
  const auto add = [&](const JPH::Ref<JPH::Shape>& shape, const JPH::Vec3& at) {
    JPH::BodyCreationSettings settings(shape, JPH::RVec3(at), JPH::Quat::sIdentity(), JPH::EMotionType::Dynamic, 0);
    settings.mOverrideMassProperties = JPH::EOverrideMassProperties::MassAndInertiaProvided;
    settings.mMassPropertiesOverride = mesh.mass_properties(1);
    return world.add(settings);
  };
  const JPH::BodyID lower = add(dumbbell, {0, 0, 0.55F}), upper = add(half, {1, 0, 1.4F});
  const JPH::Ref<JPH::SphereShape> sphere = new JPH::SphereShape(0.1F);
  sphere->SetDensity(10);
  const JPH::BodyID ball = world.add(
      JPH::BodyCreationSettings(sphere, JPH::RVec3(0, 0, 1), JPH::Quat::sIdentity(), JPH::EMotionType::Dynamic, 0));
  world.run(3);
  EXPECT_TRUE(world.contacts->take_errors().empty());
  EXPECT_NEAR(world.position(lower).z(), 0.5, 3e-3);
  EXPECT_NEAR(world.position(upper).z(), 1.25, 5e-3);
  EXPECT_NEAR(world.position(ball).z(), 0.9, 5e-3);  // on the box, by Jolt's own contact
}

TEST_F(JoltContactsTest, SaysWhyPairsHaveNoContacts) {
  JoltWorld world;
  world.add_ground();
  const JoltMesh mesh(cube(0.5));
  world.contacts->add(mesh);
  JPH::BodyCreationSettings settings = mesh.body_settings(JPH::RVec3(0, 0, 0.4F), JPH::Quat::sIdentity(), 0, 1);
  settings.SetShape(new JPH::ScaledShape(mesh.jolt_shape(), {1, 2, 1}));
  world.add(settings);
  world.run(0.1);
  const std::vector<std::string> errors = world.contacts->take_errors();
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors[0], "Jolt mesh: its scale has to be one positive factor for all axes");
  world.run(0.1);
  EXPECT_TRUE(world.contacts->take_errors().empty());
}

TEST_F(JoltContactsTest, SensorsFindBodiesThatTouch) {
  JoltWorld world;
  world.system.SetGravity(JPH::Vec3::sZero());
  world.system.SetContactListener(&world.manifolds);
  const JoltMesh mesh(cube(0.5));
  world.contacts->add(mesh);
  JPH::BodyCreationSettings sensor = mesh.body_settings(JPH::RVec3::sZero(), JPH::Quat::sIdentity(), 0, 1);
  sensor.mIsSensor = true;
  world.add(sensor);
  const JPH::BodyID near = world.add(mesh, {1.005, 0, 0});
  world.run(0.1);
  EXPECT_EQ(world.manifolds.added, 0);
  world.bodies().SetPosition(near, JPH::RVec3(0.9F, 0, 0), JPH::EActivation::Activate);
  world.run(0.1);
  EXPECT_GT(world.manifolds.added, 0);
  EXPECT_NEAR(world.position(near).x(), 0.9, 1e-6);
}

TEST_F(JoltContactsTest, OutcomeDoesNotDependOnThreads) {
  const auto outcome = [](int threads) {
    const JoltMesh ring(shapes::torus(0.6, 0.2, 24, 12));
    JoltWorld world;
    world.add_ground();
    std::vector<JPH::BodyID> ids;
    for (int i = 0; i < 12; ++i) ids.push_back(world.add(ring, {0.4 * (i % 3), 0.3 * (i % 2), 0.5 + 0.6 * i}));
    JPH::JobSystemThreadPool pool(JPH::cMaxPhysicsJobs, JPH::cMaxPhysicsBarriers, threads);
    world.run(3, threads > 0 ? &pool : nullptr);
    std::vector<float> result;
    for (const JPH::BodyID id : ids) {
      JPH::RVec3 position;
      JPH::Quat rotation;
      world.bodies().GetPositionAndRotation(id, position, rotation);
      for (const float x : {static_cast<float>(position.GetX()), static_cast<float>(position.GetY()),
                            static_cast<float>(position.GetZ()), rotation.GetX(), rotation.GetW()}) {
        result.push_back(x);
      }
    }
    return result;
  };
  const std::vector<float> expected = outcome(0);
  EXPECT_EQ(outcome(0), expected);
  EXPECT_EQ(outcome(3), expected);
}

TEST_F(JoltContactsTest, GivesTheSystemItsFunctionBack) {
  int calls = 0;
  JoltWorld world;
  world.contacts.reset();
  world.system.SetSimCollideBodyVsBody([&](auto&&...) { ++calls; });
  {
    JoltContacts contacts(world.system);
    const JoltMesh mesh(cube(0.5));
    contacts.add(mesh);
    world.add_ground();
    world.add(mesh.body_settings(JPH::RVec3(0, 0, 0.5F), JPH::Quat::sIdentity(), 0, 1));
    world.run(0.1);
    EXPECT_EQ(calls, 0);
    contacts.remove(mesh);
    world.bodies().SetPosition(world.add(mesh.body_settings(JPH::RVec3(5, 0, 0.5F), JPH::Quat::sIdentity(), 0, 1)),
                               JPH::RVec3(5, 0, 0.4F), JPH::EActivation::Activate);
    world.run(0.1);
    EXPECT_GT(calls, 0);
  }
  const int before = calls;
  world.run(0.5);
  EXPECT_GT(calls, before);
}

TEST_F(JoltContactsTest, RefusesOptionsOutOfRange) {
  const auto error = [](const JoltContactOptions& options) -> std::string {
    try {
      JoltWorld world(options);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(error({.skin = -1}), "Jolt contacts: skin is -1.000000, it has to be 0.000000 to 1.000000");
  EXPECT_NE(error({.most_speculation = std::nan("")}).find("most_speculation"), std::string::npos);
  EXPECT_NE(error({.most_points = 0}).find("most_points"), std::string::npos);
  EXPECT_NE(error({.most_per_patch = 5}).find("most_per_patch"), std::string::npos);
}

}  // namespace
}  // namespace encage::test
