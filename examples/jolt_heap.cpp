// SPDX-License-Identifier: Apache-2.0
// Pours bodies of one asset into a pit, in Jolt: a heap of dynamic concave meshes.
#include <encage/jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyInterface.h>
#include <Jolt/Physics/Collision/BroadPhase/BroadPhaseLayer.h>
#include <Jolt/RegisterTypes.h>

#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

class OneLayer final : public JPH::BroadPhaseLayerInterface {
 public:
  JPH::uint GetNumBroadPhaseLayers() const override { return 1; }
  JPH::BroadPhaseLayer GetBroadPhaseLayer(JPH::ObjectLayer) const override { return JPH::BroadPhaseLayer(0); }
#if defined(JPH_EXTERNAL_PROFILE) || defined(JPH_PROFILE_ENABLED)
  const char* GetBroadPhaseLayerName(JPH::BroadPhaseLayer) const override { return "all"; }
#endif
};

int run(const char* asset, int count, double seconds) {
  OneLayer layers;
  const JPH::ObjectVsBroadPhaseLayerFilter all_layers;
  const JPH::ObjectLayerPairFilter all_pairs;
  JPH::TempAllocatorImpl memory(64 << 20);
  JPH::JobSystemThreadPool jobs(JPH::cMaxPhysicsJobs, JPH::cMaxPhysicsBarriers, 1);
  JPH::PhysicsSystem system;
  system.Init(1024, 0, 4096, 8192, layers, all_layers, all_pairs);
  system.SetGravity({0, 0, -9.81F});

  encage::JoltContacts contacts(system);
  const encage::JoltMesh mesh{std::filesystem::path(asset)};
  contacts.add(mesh);
  const auto radius = static_cast<float>(mesh.radius());
  JPH::PhysicsSettings settings = system.GetPhysicsSettings();
  settings.mPenetrationSlop = 0.002F * radius;  // Jolt's 2 cm are for bodies of people's size
  system.SetPhysicsSettings(settings);

  JPH::BodyInterface& bodies = system.GetBodyInterface();
  std::vector<JPH::BodyID> ids;
  for (const JPH::Vec3 slope : {JPH::Vec3(1, 0, 1), JPH::Vec3(-1, 0, 1), JPH::Vec3(0, 1, 1), JPH::Vec3(0, -1, 1)}) {
    const JPH::Plane plane = JPH::Plane::sFromPointAndNormal(JPH::Vec3::sZero(), slope.Normalized());
    const JPH::BodyCreationSettings side(new JPH::PlaneShape(plane), JPH::RVec3::sZero(), JPH::Quat::sIdentity(),
                                         JPH::EMotionType::Static, 0);
    bodies.CreateAndAddBody(side, JPH::EActivation::DontActivate);
  }
  for (int i = 0; i < count; ++i) {
    const JPH::Vec3 at(0.3F * radius * static_cast<float>(i % 2), 0, radius * static_cast<float>(3 + 2 * i));
    const JPH::Quat turn = JPH::Quat::sEulerAngles({0.7F * static_cast<float>(i), static_cast<float>(i), 0});
    // Positions are those of the frame, and the centre of mass may be elsewhere in it.
    const JPH::RVec3 position(at - turn * mesh.jolt_shape()->GetCenterOfMass());
    const JPH::BodyCreationSettings body = mesh.body_settings(position, turn, 0, 1000);
    ids.push_back(bodies.CreateAndAddBody(body, JPH::EActivation::Activate));
  }
  for (int step = 0; step < static_cast<int>(60 * seconds); ++step) system.Update(1 / 60.F, 1, &memory, &jobs);

  int asleep = 0;
  float top = 0;
  for (const JPH::BodyID id : ids) {
    asleep += !bodies.IsActive(id);
    top = std::max(top, static_cast<float>(bodies.GetCenterOfMassPosition(id).GetZ()) / radius);
  }
  std::printf("%d bodies, the highest at %.2f radii, %d asleep\n", count, static_cast<double>(top), asleep);
  for (const std::string& error : contacts.take_errors()) std::fprintf(stderr, "%s\n", error.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: %s ASSET BODIES SECONDS\n", argv[0]);
    return 2;
  }
  JPH::RegisterDefaultAllocator();
  JPH::Factory::sInstance = new JPH::Factory;
  JPH::RegisterTypes();
  int status = 1;
  try {
    status = run(argv[1], std::atoi(argv[2]), std::atof(argv[3]));
  } catch (const encage::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
  }
  JPH::UnregisterTypes();
  delete JPH::Factory::sInstance;
  return status;
}
