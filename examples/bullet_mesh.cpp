// SPDX-License-Identifier: Apache-2.0
// Drops a body on a copy of itself, in Bullet: two dynamic concave meshes, at rest on a plane in the end.
#include <encage/bullet_mesh.h>

#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s ASSET SECONDS\n", argv[0]);
    return 2;
  }
  try {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    encage::BulletMeshContacts contacts(dispatcher);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.setGravity({0, 0, -9.81F});

    encage::BulletMeshShape shape(encage::load_shape(argv[1]), {.frame = encage::BulletFrame::principal});
    btVector3 inertia;
    shape.calculateLocalInertia(1, inertia);
    btStaticPlaneShape ground({0, 0, 1}, 0);
    btRigidBody floor(0, nullptr, &ground), lower(1, nullptr, &shape, inertia), upper(1, nullptr, &shape, inertia);
    const auto radius = static_cast<btScalar>(shape.radius());
    lower.getWorldTransform().setOrigin({0, 0, radius});
    upper.getWorldTransform().setOrigin({0.1F * radius, 0, 3.2F * radius});
    for (btRigidBody* const body : {&floor, &lower, &upper}) world.addRigidBody(body);

    const int steps = static_cast<int>(60 * std::atof(argv[2]));
    for (int i = 0; i < steps; ++i) world.stepSimulation(1 / 60.F, 0);
    int points = 0;
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m)
      points += dispatcher.getManifoldByIndexInternal(m)->getNumContacts();
    std::printf("heights %.3f and %.3f, %d contact points, %s\n", lower.getWorldTransform().getOrigin().z(),
                upper.getWorldTransform().getOrigin().z(), points, lower.isActive() ? "awake" : "asleep");
    for (btRigidBody* const body : {&floor, &lower, &upper}) world.removeRigidBody(body);
  } catch (const encage::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
