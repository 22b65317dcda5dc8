// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/meshes.h"

#include <encage/bullet_mesh.h>

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <utility>
#include <vector>

namespace encage::test {

inline std::unique_ptr<BulletMeshShape> mesh_shape(const TriangleMesh& mesh) {
  return std::make_unique<BulletMeshShape>(make_shape(mesh));
}

/// A world with gravity 10 downward, along -z. It owns bodies and shapes.
class MeshWorld {
 public:
  explicit MeshWorld(const BulletMeshOptions& options = {})
      : dispatcher(&configuration),
        contacts(std::make_unique<BulletMeshContacts>(dispatcher, options)),
        world(&dispatcher, &broadphase, &solver, &configuration) {
    world.setGravity({0, 0, -10});
  }
  ~MeshWorld() {
    for (const auto& body : bodies_) world.removeRigidBody(body.get());
  }
  MeshWorld(const MeshWorld&) = delete;
  MeshWorld& operator=(const MeshWorld&) = delete;

  template <class Shape>
  Shape& keep(std::unique_ptr<Shape> shape) {
    shapes_.push_back(std::move(shape));
    return static_cast<Shape&>(*shapes_.back());
  }

  btRigidBody& add(btCollisionShape& shape, const btVector3& at, double mass = 1) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape.calculateLocalInertia(static_cast<btScalar>(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, &shape, inertia);
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin(at);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    world.addRigidBody(bodies_.back().get());
    return *bodies_.back();
  }

  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(60 * seconds + 0.5); ++i) world.stepSimulation(1 / 60.F, 0);
  }

  /// All points of all manifolds.
  std::vector<btManifoldPoint> points() const {
    std::vector<btManifoldPoint> all;
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
      for (int i = 0; i < manifold.getNumContacts(); ++i) all.push_back(manifold.getContactPoint(i));
    }
    return all;
  }

  double impulse() const {
    double sum = 0;
    for (const btManifoldPoint& point : points()) sum += static_cast<double>(point.getAppliedImpulse());
    return sum;
  }

  btDefaultCollisionConfiguration configuration;
  mutable btCollisionDispatcher dispatcher;  // for getters that Bullet forgot to make const
  std::unique_ptr<BulletMeshContacts> contacts;
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world;

 private:
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

}  // namespace encage::test
