// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/body.h"
#include "oracles/bullet_contact_points.h"

#include <encage/bullet.h>

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <optional>
#include <vector>

namespace encage::test {

using bullet_bench::ContactPoint;

/// A sample as Bullet sees it: its fine mesh in the body frame, in float.
class BulletMesh {
 public:
  explicit BulletMesh(const TriangleMesh& mesh, double margin = 0, const btVector3& scaling = {1, 1, 1});
  /// Returns the mesh in the body frame.
  static TriangleMesh of(const Body& body);

  btGImpactMeshShape& shape() { return *shape_; }

 private:
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> vertices_;  // arrays_ points into both
  Triangles triangles_;
  btTriangleIndexVertexArray arrays_;
  std::unique_ptr<btGImpactMeshShape> shape_;
};

btTransform placed(const btVector3& at, const btQuaternion& turn = btQuaternion::getIdentity());

/// A Bullet world with GImpact, on request with an adapter.
class BulletWorld {
 public:
  explicit BulletWorld(std::optional<BulletContacts> adapter = {});
  ~BulletWorld();

  /// Adds a body, which takes part until it is removed. Bodies are numbered from 0.
  btRigidBody& add(btCollisionShape& shape, const btTransform& pose, double mass = 1);
  void remove(btRigidBody& body) { world.removeRigidBody(&body); }
  /// Adds six walls of a cube about the origin.
  void add_walls(double half);

  std::vector<ContactPoint> detect();  ///< runs collision detection at the present poses
  void step(double dt) { world.stepSimulation(static_cast<btScalar>(dt), 0); }
  std::vector<ContactPoint> contacts() { return bullet_bench::contact_points(dispatcher); }
  std::vector<float> transforms() const;

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  std::unique_ptr<BulletAdapter> adapter;
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world;

 private:
  std::vector<std::unique_ptr<btStaticPlaneShape>> walls_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

/// Returns one of sample_shapes() or large_sample_shapes().
Body body_named(const std::string& name);

}  // namespace encage::test
