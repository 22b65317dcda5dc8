// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/bullet.h>
#include <encage/encage.h>

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include <array>
#include <cstdio>

// The adapter for Bullet, linked in whatever way: two tetrahedra whose bounding boxes overlap, proven apart, and a
// third that touches one of them.
int main() {
  encage::CageHierarchy hierarchy;
  hierarchy.fine.vertices.resize(4, 3);
  hierarchy.fine.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  hierarchy.fine.triangles.resize(4, 3);
  hierarchy.fine.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  hierarchy.source_volume = 1.0 / 6;
  hierarchy.diagonal = 1.7320508075688772;

  std::array<btScalar, 12> vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<int, 12> triangles = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  btTriangleIndexVertexArray arrays(4, triangles.data(), 3 * sizeof(int), 4, vertices.data(), 3 * sizeof(btScalar));
  btGImpactMeshShape mesh(&arrays);
  mesh.setMargin(0.001F);
  mesh.updateBound();

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
  encage::BulletAdapter adapter(dispatcher, encage::BulletContacts::within_margins);
  btDbvtBroadphase broadphase;
  btCollisionWorld world(&dispatcher, &broadphase, &configuration);
  adapter.attach(mesh, encage::make_shape(hierarchy));
  std::array<btCollisionObject, 3> objects;
  const std::array<btVector3, 3> places = {btVector3(0, 0, 0), btVector3(0.6F, 0.6F, 0.6F),
                                           btVector3(-0.5F, 0.1F, 0.1F)};
  for (std::size_t i = 0; i < objects.size(); ++i) {
    objects[i].setCollisionShape(&mesh);
    objects[i].setWorldTransform(btTransform(btQuaternion::getIdentity(), places[i]));
    world.addCollisionObject(&objects[i]);
  }
  world.performDiscreteCollisionDetection();
  int contacts = 0;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    contacts += dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
  }
  const encage::BulletStatistics statistics = adapter.statistics();
  for (btCollisionObject& object : objects) world.removeCollisionObject(&object);

  bool caught = false;
  try {
    adapter.attach(mesh, nullptr);
  } catch (const encage::Error&) {
    caught = true;
  }
  std::printf("Encage with Bullet: asked %d, rejected %d, touch %d, error caught %d\n",
              static_cast<int>(statistics.asked), static_cast<int>(statistics.rejected), contacts > 0, caught);
  return statistics.rejected >= 1 && statistics.rejected < statistics.asked && contacts > 0 && caught ? 0 : 1;
}
