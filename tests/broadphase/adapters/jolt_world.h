// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/meshes.h"

#include <encage/jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyInterface.h>
#include <Jolt/Physics/Collision/BroadPhase/BroadPhaseLayer.h>
#include <Jolt/Physics/Collision/ContactListener.h>
#include <Jolt/RegisterTypes.h>

#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace encage::test {

/// What Jolt wants to be done once in a process.
inline void register_jolt() {
  static const bool done = [] {
    JPH::RegisterDefaultAllocator();
    JPH::Factory::sInstance = new JPH::Factory;
    JPH::RegisterTypes();
    return true;
  }();
  static_cast<void>(done);
}

class OneLayer final : public JPH::BroadPhaseLayerInterface {
 public:
  JPH::uint GetNumBroadPhaseLayers() const override { return 1; }
  JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer) const override { return JPH::BroadPhaseLayer(0); }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
  const char* GetBroadPhaseLayerName(JPH::BroadPhaseLayer) const override { return "all"; }
#endif
};

/// Records the manifolds of the last step, and how many have begun. For one thread.
class Manifolds final : public JPH::ContactListener {
 public:
  void OnContactAdded(const JPH::Body&, const JPH::Body&, const JPH::ContactManifold& manifold,
                      JPH::ContactSettings&) override {
    ++added;
    now.push_back(manifold);
  }
  void OnContactPersisted(const JPH::Body&, const JPH::Body&, const JPH::ContactManifold& manifold,
                          JPH::ContactSettings&) override {
    now.push_back(manifold);
  }

  std::vector<JPH::ContactManifold> now;
  int added = 0;
};

/// A world with gravity 10 downward, along -z, in which bodies may sink into each other by 1 mm.
class JoltWorld {
 public:
  explicit JoltWorld(const JoltContactOptions& options = {}) {
    system.Init(1024, 0, 1024, 4096, layers_, all_layers_, all_pairs_);
    system.SetGravity({0, 0, -10});
    JPH::PhysicsSettings settings = system.GetPhysicsSettings();
    settings.mPenetrationSlop = 0.001F;
    system.SetPhysicsSettings(settings);
    contacts = std::make_unique<JoltContacts>(system, options);
  }
  ~JoltWorld() {
    for (const JPH::BodyID id : ids_) {
      bodies().RemoveBody(id);
      bodies().DestroyBody(id);
    }
  }
  JoltWorld(const JoltWorld&) = delete;
  JoltWorld& operator=(const JoltWorld&) = delete;

  JPH::BodyInterface& bodies() { return system.GetBodyInterface(); }

  JPH::BodyID add(JPH::BodyCreationSettings settings) {
    ids_.push_back(bodies().CreateAndAddBody(settings, JPH::EActivation::Activate));
    return ids_.back();
  }
  /// A body of a mesh, which the contacts know from now on.
  JPH::BodyID add(const JoltMesh& mesh, const Eigen::Vector3d& at, float density = 1) {
    contacts->add(mesh);
    return add(mesh.body_settings(JPH::RVec3(jolt::to_jolt(at)), JPH::Quat::sIdentity(), 0, density));
  }
  JPH::BodyID add_static(const JPH::Shape* shape, const Eigen::Vector3d& at = Eigen::Vector3d::Zero()) {
    return add(JPH::BodyCreationSettings(shape, JPH::RVec3(jolt::to_jolt(at)), JPH::Quat::sIdentity(),
                                         JPH::EMotionType::Static, 0));
  }
  JPH::BodyID add_ground() { return add_static(new JPH::PlaneShape(JPH::Plane(JPH::Vec3(0, 0, 1), 0), nullptr, 100)); }

  void run(double seconds, JPH::JobSystem* jobs = nullptr) {
    for (int i = 0; i < static_cast<int>(60 * seconds + 0.5); ++i) {
      manifolds.now.clear();
      system.Update(1 / 60.F, 1, &memory_, jobs != nullptr ? jobs : &single_);
    }
  }

  Eigen::Vector3d position(JPH::BodyID id) { return jolt::to_eigen(JPH::Vec3(bodies().GetPosition(id))); }

  JPH::PhysicsSystem system;
  std::unique_ptr<JoltContacts> contacts;
  Manifolds manifolds;  ///< unless it is made the listener, empty

 private:
  OneLayer layers_;
  JPH::ObjectVsBroadPhaseLayerFilter all_layers_;
  JPH::ObjectLayerPairFilter all_pairs_;
  JPH::TempAllocatorImpl memory_{32 << 20};
  JPH::JobSystemSingleThreaded single_{JPH::cMaxPhysicsJobs};
  std::vector<JPH::BodyID> ids_;
};

}  // namespace encage::test
