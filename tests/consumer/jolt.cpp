// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/RegisterTypes.h>

#include <cstdio>

// The adapter for Jolt, linked in whatever way: a tetrahedron has its mass, and a surface has none.
int main() {
  JPH::RegisterDefaultAllocator();
  JPH::Factory::sInstance = new JPH::Factory;
  JPH::RegisterTypes();
  int caught = 0;
  double mass = 0;
  {
    encage::TriangleMesh mesh;
    mesh.vertices.resize(4, 3);
    mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    mesh.triangles.resize(4, 3);
    mesh.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
    JPH::PhysicsSystem system;
    encage::JoltContacts contacts(system);
    const encage::JoltMesh solid(mesh);
    contacts.add(solid);
    mass = static_cast<double>(solid.mass_properties(6).mMass);
    mesh.triangles.conservativeResize(3, 3);
    try {
      encage::JoltMesh(mesh).mass_properties(6);
    } catch (const encage::Error&) {
      ++caught;
    }
  }
  JPH::UnregisterTypes();
  delete JPH::Factory::sInstance;
  std::printf("Encage with Jolt: mass %.3f, error caught %d\n", mass, caught);
  return mass > 0.999 && mass < 1.001 && caught == 1 ? 0 : 1;
}
