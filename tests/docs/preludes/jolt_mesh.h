// SPDX-License-Identifier: GPL-3.0-or-later
// needs: jolt
#include <encage/jolt.h>

#include <Jolt/Core/JobSystem.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyInterface.h>
#include <Jolt/Physics/PhysicsSystem.h>

#include <cstddef>
// Not constructed: Jolt's allocator is not registered here.
alignas(JPH::PhysicsSystem) std::byte storage[sizeof(JPH::PhysicsSystem)];
JPH::PhysicsSystem& system = *reinterpret_cast<JPH::PhysicsSystem*>(storage);
JPH::RVec3 position;
JPH::Quat rotation;
JPH::ObjectLayer layer = 0;
float density = 1000;
JPH::TempAllocator* temp_allocator = nullptr;
JPH::JobSystem* job_system = nullptr;
