// SPDX-License-Identifier: GPL-3.0-or-later
// Several worlds run at once, each with its own adapter; they share the shape.
#include "tests/broadphase/adapters/bullet_mesh_world.h"
#include "tests/broadphase/adapters/bullet_world.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>
#include <vector>

namespace encage::test {
namespace {

std::vector<float> simulate(const Body& body, bool with_adapter) {
  BulletMesh mesh(BulletMesh::of(body), 0.01);
  BulletWorld world(with_adapter ? std::optional(BulletContacts::all) : std::nullopt);
  if (with_adapter) world.adapter->attach(mesh.shape(), body.shape);
  for (int i = 0; i < 6; ++i) {
    btRigidBody& added = world.add(mesh.shape(), placed({static_cast<btScalar>(i % 3) * 2, 0.4F, 0}));
    if (i >= 3) added.setWorldTransform(placed({static_cast<btScalar>(i % 3) * 2, 0, 1.5F}));
  }
  world.add_walls(5);
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  EXPECT_TRUE(!with_adapter || world.adapter->statistics().rejected > 0);
  return world.transforms();
}

TEST(BulletThreads, WorldsAreIndependent) {
  const Body body = body_named("torus");
  const std::vector<float> expected = simulate(body, false);
  std::vector<std::vector<float>> results(4);
  {
    std::vector<std::jthread> threads;
    for (auto& result : results) threads.emplace_back([&] { result = simulate(body, true); });
  }
  for (const auto& result : results) EXPECT_EQ(result, expected);
}

std::vector<float> stack_up(const BulletMeshShape& shape) {
  MeshWorld w;
  auto& ground = w.keep(std::make_unique<btBoxShape>(btVector3(9, 9, 1)));
  w.add(ground, {0, 0, -1}, 0);
  std::vector<btRigidBody*> bodies;
  for (int i = 0; i < 6; ++i) {
    bodies.push_back(&w.add(const_cast<BulletMeshShape&>(shape),
                            {0.2F * static_cast<btScalar>(i), 0, 3.F + 3.F * static_cast<btScalar>(i)}));
  }
  w.run(1.5);
  std::vector<float> numbers;
  for (const btRigidBody* body : bodies) {
    std::array<btScalar, 16> matrix{};
    body->getWorldTransform().getOpenGLMatrix(matrix.data());
    numbers.insert(numbers.end(), matrix.begin(), matrix.end());
  }
  return numbers;
}

TEST(BulletThreads, WorldsMayShareAMeshShape) {
  const auto shape = mesh_shape(BulletMesh::of(body_named("torus")));
  const std::vector<float> expected = stack_up(*shape);
  std::vector<std::vector<float>> results(4);
  {
    std::vector<std::jthread> threads;
    for (auto& result : results) threads.emplace_back([&] { result = stack_up(*shape); });
  }
  for (const auto& result : results) EXPECT_EQ(result, expected);
}

}  // namespace
}  // namespace encage::test
