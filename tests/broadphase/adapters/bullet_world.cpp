// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/adapters/bullet_world.h"

#include <array>
#include <stdexcept>
#include <utility>

namespace encage::test {

BulletMesh::BulletMesh(const TriangleMesh& mesh, double margin, const btVector3& scaling)
    : vertices_(mesh.vertices.cast<float>()),
      triangles_(mesh.triangles),
      arrays_(static_cast<int>(triangles_.rows()), triangles_.data(), 3 * sizeof(std::int32_t),
              static_cast<int>(vertices_.rows()), vertices_.data(), 3 * sizeof(float)),
      shape_(std::make_unique<btGImpactMeshShape>(&arrays_)) {
  shape_->setLocalScaling(scaling);
  shape_->setMargin(static_cast<btScalar>(margin));
  shape_->updateBound();
}

TriangleMesh BulletMesh::of(const Body& body) {
  TriangleMesh mesh = body.sample.hierarchy.fine;
  mesh.vertices.rowwise() += body.origin().transpose();
  return mesh;
}

btTransform placed(const btVector3& at, const btQuaternion& turn) { return btTransform(turn, at); }

BulletWorld::BulletWorld(std::optional<BulletContacts> contacts)
    : dispatcher(&configuration), world(&dispatcher, &broadphase, &solver, &configuration) {
  btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
  if (contacts) adapter = std::make_unique<BulletAdapter>(dispatcher, *contacts);
}

BulletWorld::~BulletWorld() {
  for (const auto& body : bodies_) world.removeRigidBody(body.get());
}

btRigidBody& BulletWorld::add(btCollisionShape& shape, const btTransform& pose, double mass) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0) shape.calculateLocalInertia(static_cast<btScalar>(mass), inertia);
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, &shape, inertia);
  info.m_startWorldTransform = pose;
  info.m_restitution = 0.9F;
  bodies_.push_back(std::make_unique<btRigidBody>(info));
  btRigidBody& body = *bodies_.back();
  body.setUserIndex(static_cast<int>(bodies_.size()) - 1);
  body.setActivationState(DISABLE_DEACTIVATION);
  world.addRigidBody(&body);
  return body;
}

void BulletWorld::add_walls(double half) {
  for (int k = 0; k < 6; ++k) {
    btVector3 normal(0, 0, 0);
    normal[k / 2] = static_cast<btScalar>(k % 2 ? -1 : 1);
    walls_.push_back(std::make_unique<btStaticPlaneShape>(normal, static_cast<btScalar>(-half)));
    add(*walls_.back(), btTransform::getIdentity(), 0);
  }
}

std::vector<ContactPoint> BulletWorld::detect() {
  world.performDiscreteCollisionDetection();
  return contacts();
}

std::vector<float> BulletWorld::transforms() const {
  std::vector<float> numbers;
  for (const auto& body : bodies_) {
    std::array<btScalar, 16> matrix{};
    body->getWorldTransform().getOpenGLMatrix(matrix.data());
    numbers.insert(numbers.end(), matrix.begin(), matrix.end());
  }
  return numbers;
}

Body body_named(const std::string& name) {
  for (auto samples : {sample_shapes(0), large_sample_shapes(0)}) {
    for (Sample& sample : samples) {
      if (sample.name == name) return Body(std::move(sample));
    }
  }
  throw std::invalid_argument(name);
}

}  // namespace encage::test
