// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/jolt/jolt_world.h"

#include "bench/common/clock.h"

#include <encage/error.h>
#include <encage/jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyInterface.h>
#include <Jolt/Physics/Collision/BroadPhase/BroadPhaseLayer.h>
#include <Jolt/Physics/Collision/ContactListener.h>
#include <Jolt/RegisterTypes.h>

#include <set>
#include <utility>

namespace encage::jolt_bench {
namespace {

/// Sets up what Jolt keeps for the whole process.
struct Registration {
  Registration() {
    JPH::RegisterDefaultAllocator();
    JPH::Factory::sInstance = new JPH::Factory;
    JPH::RegisterTypes();
  }
  ~Registration() {
    JPH::UnregisterTypes();
    delete JPH::Factory::sInstance;
    JPH::Factory::sInstance = nullptr;
  }
};

/// One layer of moving bodies and one of the others.
class Layers final : public JPH::BroadPhaseLayerInterface {
 public:
  static constexpr JPH::ObjectLayer resting = 0, moving = 1;
  JPH::uint GetNumBroadPhaseLayers() const override { return 2; }
  JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer layer) const override {
    return JPH::BroadPhaseLayer(static_cast<JPH::BroadPhaseLayer::Type>(layer));
  }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
  const char* GetBroadPhaseLayerName(JPH::BroadPhaseLayer) const override { return "layer"; }
#endif
};

class AllLayers final : public JPH::ObjectVsBroadPhaseLayerFilter {};

class MovingPairs final : public JPH::ObjectLayerPairFilter {
 public:
  bool ShouldCollide(JPH::ObjectLayer a, JPH::ObjectLayer b) const override {
    return a == Layers::moving || b == Layers::moving;
  }
};

/// Counts the points of the contacts that the solver is given.
class ContactCount final : public JPH::ContactListener {
 public:
  void OnContactAdded(const JPH::Body& a, const JPH::Body& b, const JPH::ContactManifold& manifold,
                      JPH::ContactSettings&) override {
    add(a, b, manifold);
  }
  void OnContactPersisted(const JPH::Body& a, const JPH::Body& b, const JPH::ContactManifold& manifold,
                          JPH::ContactSettings&) override {
    add(a, b, manifold);
  }
  void clear() {
    points = 0;
    pairs.clear();
  }

  std::int64_t points = 0;
  std::set<std::pair<JPH::BodyID, JPH::BodyID>> pairs;

 private:
  void add(const JPH::Body& a, const JPH::Body& b, const JPH::ContactManifold& manifold) {
    points += manifold.mRelativeContactPointsOn1.size();
    pairs.insert(std::minmax(a.GetID(), b.GetID()));
  }
};

JPH::Vec3 to_jolt(const Eigen::Vector3d& v) { return jolt::to_jolt(v); }

JPH::Quat to_quaternion(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaternionf q(rotation.cast<float>());
  return JPH::Quat(q.x(), q.y(), q.z(), q.w()).Normalized();
}

}  // namespace

struct JoltWorld::World {
  explicit World(const JoltSettings& options) {
    system.Init(1024, 0, 4096, 8192, layers, all_layers, moving_pairs);
    JPH::PhysicsSettings settings = system.GetPhysicsSettings();
    settings.mPenetrationSlop = static_cast<float>(options.penetration_slop);
    system.SetPhysicsSettings(settings);
    system.SetGravity({0, 0, -9.81F});
    system.SetContactListener(&count);
    contacts = std::make_unique<JoltContacts>(system);
    system.SetSimCollideBodyVsBody([this, inner = system.GetSimCollideBodyVsBody()](auto&&... arguments) {
      const bench::CpuTimer timer(detect_seconds);
      inner(std::forward<decltype(arguments)>(arguments)...);
    });
  }
  ~World() {
    JPH::BodyInterface& interface = system.GetBodyInterface();
    for (const std::vector<JPH::BodyID>* const ids : {&bodies, &planes}) {
      for (const JPH::BodyID id : *ids) {
        interface.RemoveBody(id);
        interface.DestroyBody(id);
      }
    }
  }

  JPH::BodyID add(JPH::BodyCreationSettings& settings, double friction) {
    settings.mFriction = static_cast<float>(friction);
    settings.mRestitution = 0;
    settings.mAllowSleeping = false;
    return system.GetBodyInterface().CreateAndAddBody(settings, JPH::EActivation::Activate);
  }

  Registration registration;
  Layers layers;
  AllLayers all_layers;
  MovingPairs moving_pairs;
  ContactCount count;
  JPH::PhysicsSystem system;
  std::unique_ptr<JoltContacts> contacts;
  JPH::TempAllocatorImpl memory{64 << 20};
  JPH::JobSystemSingleThreaded jobs{JPH::cMaxPhysicsJobs};
  std::vector<JPH::BodyID> bodies, planes;
  double detect_seconds = 0;
};

JoltWorld::JoltWorld(const bullet_bench::Scene& scene, const std::vector<bullet_bench::SceneBody>& bodies,
                     const JoltSettings& options)
    : world_(std::make_unique<World>(options)) {
  std::vector<JoltMesh> meshes;
  for (const TriangleMesh& mesh : scene.meshes) {
    meshes.emplace_back(mesh);
    world_->contacts->add(meshes.back());
  }
  for (const bullet_bench::SceneBody& body : bodies) {
    const JoltMesh& mesh = meshes[static_cast<std::size_t>(body.mesh)];
    const float density = 1 / mesh.mass_properties(1).mMass;
    JPH::BodyCreationSettings settings = mesh.body_settings(JPH::RVec3(to_jolt(body.pose.translation())),
                                                            to_quaternion(body.pose.linear()), Layers::moving, density);
    settings.mUseManifoldReduction = options.reduces;
    if (!body.moves) {
      settings.mMotionType = JPH::EMotionType::Static;
      settings.mObjectLayer = Layers::resting;
    }
    world_->bodies.push_back(world_->add(settings, scene.friction));
  }
  for (const HalfSpace& plane : scene.planes) {
    JPH::PlaneShapeSettings shape(JPH::Plane(to_jolt(plane.normal), static_cast<float>(-plane.offset)), nullptr, 100);
    shape.SetEmbedded();
    JPH::BodyCreationSettings settings(shape.Create().Get(), JPH::RVec3::sZero(), JPH::Quat::sIdentity(),
                                       JPH::EMotionType::Static, Layers::resting);
    world_->planes.push_back(world_->add(settings, scene.friction));
  }
  world_->system.OptimizeBroadPhase();
}

JoltWorld::~JoltWorld() = default;

bullet_bench::StepCost JoltWorld::step() {
  world_->detect_seconds = 0;
  world_->count.clear();
  const double all = bench::cpu_milliseconds(
      [&] { world_->system.Update(1.0F / bullet_bench::steps_per_second, 1, &world_->memory, &world_->jobs); });
  const std::vector<std::string> errors = world_->contacts->take_errors();
  if (!errors.empty()) throw Error(errors.front());
  return {1e3 * world_->detect_seconds, all};
}

bullet_bench::StepContacts JoltWorld::contacts() const {
  return {world_->count.points, static_cast<std::int64_t>(world_->count.pairs.size())};
}

bullet_bench::StepMotion JoltWorld::motion() const {
  bullet_bench::StepMotion motion;
  int moving = 0;
  const JPH::BodyInterface& interface = world_->system.GetBodyInterfaceNoLock();
  for (const JPH::BodyID id : world_->bodies) {
    if (interface.GetMotionType(id) == JPH::EMotionType::Static) continue;
    motion.linear += static_cast<double>(interface.GetLinearVelocity(id).LengthSq());
    motion.angular += static_cast<double>(interface.GetAngularVelocity(id).LengthSq());
    ++moving;
  }
  return {motion.linear / moving, motion.angular / moving};
}

std::vector<Eigen::Isometry3d> JoltWorld::poses() const {
  std::vector<Eigen::Isometry3d> poses;
  const JPH::BodyInterface& interface = world_->system.GetBodyInterfaceNoLock();
  for (const JPH::BodyID id : world_->bodies) {
    JPH::RVec3 position;
    JPH::Quat rotation;
    interface.GetPositionAndRotation(id, position, rotation);
    poses.push_back(jolt::to_eigen(JPH::Vec3(position), rotation));
  }
  return poses;
}

}  // namespace encage::jolt_bench
