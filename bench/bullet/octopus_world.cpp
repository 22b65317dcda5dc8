// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/octopus_world.h"

#include "bench/common/clock.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <random>

namespace encage::bullet_bench {
namespace {

/// Asks an oracle, if there is one, before Bullet does.
class GuardedDispatcher : public btCollisionDispatcher {
 public:
  GuardedDispatcher(btCollisionConfiguration* configuration, bool oracle) : btCollisionDispatcher(configuration) {
    btGImpactCollisionAlgorithm::registerAlgorithm(this);
    if (oracle) setNearCallback(visit);
  }

  const std::set<TouchingPair>* touching = nullptr;

 private:
  static void visit(btBroadphasePair& pair, btCollisionDispatcher& self, const btDispatcherInfo& info) {
    const auto& a = *static_cast<btCollisionObject*>(pair.m_pProxy0->m_clientObject);
    const auto& b = *static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject);
    if (static_cast<GuardedDispatcher&>(self).touching->contains(numbers(a, b)) || holds_manifold(pair)) {
      defaultNearCallback(pair, self, info);
    }
  }

  static bool holds_manifold(btBroadphasePair& pair) {
    btManifoldArray manifolds;
    if (pair.m_algorithm) pair.m_algorithm->getAllContactManifolds(manifolds);
    return manifolds.size() > 0;
  }
};

class TimedWorld : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
  double milliseconds = 0;

  void performDiscreteCollisionDetection() override {
    const double start = bench::thread_cpu_seconds();
    btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
    milliseconds += 1e3 * (bench::thread_cpu_seconds() - start);
  }
};

btVector3 random_vector(std::minstd_rand& random, double length) {
  std::array<double, 3> v{};
  double norm = 0;
  while (!(norm > 0.1 && norm < 1)) {
    for (double& x : v) x = 2 * static_cast<double>(random() - random.min()) / (random.max() - random.min()) - 1;
    norm = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  const double f = length / norm;
  return {static_cast<btScalar>(f * v[0]), static_cast<btScalar>(f * v[1]), static_cast<btScalar>(f * v[2])};
}

}  // namespace

struct OctopusWorld::World {
  World(const TriangleMesh& mesh, const BulletScene& of, bool oracle)
      : scene(of),
        vertices(mesh.vertices.cast<float>()),
        triangles(mesh.triangles),
        arrays(static_cast<int>(triangles.rows()), triangles.data(), 3 * sizeof(std::int32_t),
               static_cast<int>(vertices.rows()), vertices.data(), 3 * sizeof(float)),
        mesh_shape(&arrays),
        dispatcher(&configuration, oracle) {
    static_assert(sizeof(btScalar) == sizeof(float));
    mesh_shape.setMargin(static_cast<btScalar>(scene.margin));
    mesh_shape.updateBound();
    world.setGravity({0, 0, static_cast<btScalar>(-scene.gravity)});
  }
  ~World() {
    for (const auto& body : bodies) world.removeRigidBody(body.get());
  }

  void add(btCollisionShape& shape, double mass, const btTransform& pose, const btVector3& v, const btVector3& spin) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape.calculateLocalInertia(static_cast<btScalar>(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, &shape, inertia);
    info.m_startWorldTransform = pose;
    info.m_restitution = 1;
    info.m_friction = 0;
    auto body = std::make_unique<btRigidBody>(info);
    body->setUserIndex(static_cast<int>(bodies.size()));
    body->setLinearVelocity(v);
    body->setAngularVelocity(spin);
    body->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(body.get());
    bodies.push_back(std::move(body));
  }

  /// On a cubic grid, turned at random.
  void add_bodies() {
    std::minstd_rand random(scene.seed);
    const int side = static_cast<int>(std::ceil(std::cbrt(scene.bodies)));
    const double pitch = scene.width / side;
    for (int i = 0; i < scene.bodies; ++i) {
      const auto place = [&](int k) { return static_cast<btScalar>((k + 0.5) * pitch - scene.width / 2); };
      const btQuaternion turn(random_vector(random, 1), static_cast<btScalar>(random() % 6283) / 1000);
      const btTransform pose(turn, {place(i % side), place(i / side % side), place(i / side / side)});
      const btVector3 velocity = random_vector(random, scene.speed);
      add(mesh_shape, 1, pose, velocity, random_vector(random, scene.spin));
    }
  }

  void add_walls() {
    for (int k = 0; k < 6; ++k) {
      btVector3 normal(0, 0, 0);
      normal[k / 2] = static_cast<btScalar>(k % 2 ? -1 : 1);
      walls.push_back(std::make_unique<btStaticPlaneShape>(normal, static_cast<btScalar>(-scene.width / 2)));
      add(*walls.back(), 0, btTransform::getIdentity(), {0, 0, 0}, {0, 0, 0});
    }
  }

  BulletScene scene;
  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> vertices;  // arrays points into both
  Triangles triangles;
  btTriangleIndexVertexArray arrays;
  btGImpactMeshShape mesh_shape;
  std::vector<std::unique_ptr<btStaticPlaneShape>> walls;
  btDefaultCollisionConfiguration configuration;
  GuardedDispatcher dispatcher;
  std::unique_ptr<BulletAdapter> adapter;
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  TimedWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btRigidBody>> bodies;
};

OctopusWorld::OctopusWorld(const TriangleMesh& mesh, const ShapePtr& shape, const BulletScene& scene, Guard guard,
                           BulletContacts contacts)
    : world_(std::make_unique<World>(mesh, scene, guard == Guard::oracle)) {
  if (guard == Guard::adapter) {
    world_->adapter = std::make_unique<BulletAdapter>(world_->dispatcher, contacts);
    world_->adapter->attach(world_->mesh_shape, shape);
  }
  world_->add_bodies();
  world_->add_walls();
}

OctopusWorld::~OctopusWorld() = default;

double OctopusWorld::step(const std::set<TouchingPair>& touching) {
  world_->dispatcher.touching = &touching;
  world_->world.milliseconds = 0;
  world_->world.stepSimulation(static_cast<btScalar>(world_->scene.dt), 0);
  return world_->world.milliseconds;
}

std::vector<ContactPoint> OctopusWorld::contacts() const { return contact_points(world_->dispatcher); }

std::set<TouchingPair> OctopusWorld::pairs_in_touch() const {
  std::set<TouchingPair> pairs;
  for (const ContactPoint& point : contacts()) pairs.insert(point.pair);
  return pairs;
}

std::vector<float> OctopusWorld::transforms() const {
  std::vector<float> numbers;
  for (const auto& body : world_->bodies) {
    std::array<btScalar, 16> matrix{};
    body->getWorldTransform().getOpenGLMatrix(matrix.data());
    numbers.insert(numbers.end(), matrix.begin(), matrix.end());
  }
  return numbers;
}

std::pair<std::int64_t, std::int64_t> OctopusWorld::pairs() const {
  btBroadphasePairArray& all = world_->broadphase.getOverlappingPairCache()->getOverlappingPairArray();
  std::int64_t planes = 0;
  for (int i = 0; i < all.size(); ++i) {
    planes += static_cast<btCollisionObject*>(all[i].m_pProxy0->m_clientObject)->isStaticObject() ||
              static_cast<btCollisionObject*>(all[i].m_pProxy1->m_clientObject)->isStaticObject();
  }
  return {all.size() - planes, planes};
}

BulletStatistics OctopusWorld::statistics() const {
  return world_->adapter ? world_->adapter->statistics() : BulletStatistics{};
}

}  // namespace encage::bullet_bench
