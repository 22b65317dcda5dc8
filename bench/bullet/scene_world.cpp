// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_world.h"

#include "bench/common/clock.h"

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <set>
#include <utility>

namespace encage::bullet_bench {
namespace {

class TimedDispatcher : public btCollisionDispatcher {
 public:
  using btCollisionDispatcher::btCollisionDispatcher;
  double seconds = 0;

  void dispatchAllCollisionPairs(btOverlappingPairCache* pairs, const btDispatcherInfo& info,
                                 btDispatcher* dispatcher) override {
    const bench::CpuTimer timer(seconds);
    btCollisionDispatcher::dispatchAllCollisionPairs(pairs, info, dispatcher);
  }
};

btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btTransform to_bullet(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return btTransform(btQuaternion(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                                  static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w())),
                     to_bullet(pose.translation()));
}

Eigen::Isometry3d from_bullet(const btTransform& transform) {
  const btQuaternion q = transform.getRotation();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
  const btVector3& p = transform.getOrigin();
  pose.translation() = Eigen::Vector3d(p.x(), p.y(), p.z());
  return pose;
}

}  // namespace

struct SceneWorld::World {
  World(const Scene& scene, const ContactMethod& method) : attached(method.attach(dispatcher)) {
    world.setGravity({0, 0, static_cast<btScalar>(-9.81)});
    // Bullet multiplies the coefficients of two bodies.
    friction = static_cast<btScalar>(std::sqrt(scene.friction));
  }
  ~World() {
    for (const auto& body : bodies) world.removeRigidBody(body.get());
  }

  btRigidBody& add(btCollisionShape& shape, const btTransform& pose, const btVector3& inertia, bool moves) {
    btRigidBody::btRigidBodyConstructionInfo info(moves ? 1 : 0, nullptr, &shape, moves ? inertia : btVector3(0, 0, 0));
    info.m_startWorldTransform = pose;
    info.m_friction = friction;
    auto body = std::make_unique<btRigidBody>(info);
    body->setActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(body.get());
    return *bodies.emplace_back(std::move(body));
  }

  btDefaultCollisionConfiguration configuration;
  TimedDispatcher dispatcher{&configuration};
  std::shared_ptr<void> attached;
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btScalar friction = 0;
  std::vector<std::unique_ptr<btStaticPlaneShape>> planes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;  ///< those of the scene, then the planes
  std::vector<Eigen::Isometry3d> frames;             ///< mesh -> body, of those of the scene
};

SceneWorld::SceneWorld(const Scene& scene, const std::vector<SceneBody>& bodies,
                       const std::vector<SceneBodyModel>& models, const ContactMethod& method,
                       const std::vector<std::unique_ptr<MethodShape>>& shapes)
    : world_(std::make_unique<World>(scene, method)) {
  for (const SceneBody& body : bodies) {
    const SceneBodyModel& model = models[body.mesh];
    world_->add(shapes[body.mesh]->shape(), to_bullet(body.pose * model.frame), to_bullet(model.moments), body.moves);
    world_->frames.push_back(model.frame.inverse());
  }
  for (const HalfSpace& plane : scene.planes) {
    world_->planes.push_back(
        std::make_unique<btStaticPlaneShape>(to_bullet(plane.normal), static_cast<btScalar>(plane.offset)));
    world_->add(*world_->planes.back(), btTransform::getIdentity(), {0, 0, 0}, false);
  }
}

SceneWorld::~SceneWorld() = default;

StepCost SceneWorld::step() {
  world_->dispatcher.seconds = 0;
  const double all = bench::cpu_milliseconds([&] { world_->world.stepSimulation(btScalar(1) / steps_per_second, 0); });
  return {1e3 * world_->dispatcher.seconds, all};
}

StepContacts SceneWorld::contacts() const {
  StepContacts contacts;
  std::set<std::pair<const btCollisionObject*, const btCollisionObject*>> pairs;
  for (int i = 0; i < world_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *world_->dispatcher.getManifoldByIndexInternal(i);
    if (manifold.getNumContacts() == 0) continue;
    contacts.points += manifold.getNumContacts();
    pairs.insert(std::minmax(manifold.getBody0(), manifold.getBody1()));
  }
  contacts.pairs = static_cast<std::int64_t>(pairs.size());
  return contacts;
}

StepMotion SceneWorld::motion() const {
  StepMotion motion;
  int moving = 0;
  for (const auto& body : world_->bodies) {
    if (body->isStaticObject()) continue;
    motion.linear += body->getLinearVelocity().length2();
    motion.angular += body->getAngularVelocity().length2();
    ++moving;
  }
  return {motion.linear / moving, motion.angular / moving};
}

std::vector<Eigen::Isometry3d> SceneWorld::poses() const {
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < world_->frames.size(); ++i) {
    poses.push_back(from_bullet(world_->bodies[i]->getWorldTransform()) * world_->frames[i]);
  }
  return poses;
}

}  // namespace encage::bullet_bench
