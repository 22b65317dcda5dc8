// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/bullet_engine.h"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <map>

namespace encage::replay {
namespace {

/// Hands the step's query to the near callback.
class PairDispatcher : public btCollisionDispatcher {
 public:
  explicit PairDispatcher(btCollisionConfiguration* configuration) : btCollisionDispatcher(configuration) {
    setNearCallback(visit);
    btGImpactCollisionAlgorithm::registerAlgorithm(this);
  }

  const StepQuestion* question = nullptr;
  std::vector<BodyPair> pairs;

 private:
  static void visit(btBroadphasePair& pair, btCollisionDispatcher& self, const btDispatcherInfo& info) {
    PairDispatcher& dispatcher = static_cast<PairDispatcher&>(self);
    const BodyPose& a = pose_of(*pair.m_pProxy0);
    const BodyPose& b = pose_of(*pair.m_pProxy1);
    if (dispatcher.question->skips(a, b)) return;
    defaultNearCallback(pair, dispatcher, info);
    // GImpact drops its manifold whenever it is asked again: what there is, is of this step.
    if (pair.m_algorithm && touches(*pair.m_algorithm)) dispatcher.pairs.push_back(make_pair(a.body, b.body));
  }

  static const BodyPose& pose_of(const btBroadphaseProxy& proxy) {
    return *static_cast<const BodyPose*>(static_cast<btCollisionObject*>(proxy.m_clientObject)->getUserPointer());
  }

  static bool touches(btCollisionAlgorithm& algorithm) {
    btManifoldArray manifolds;
    algorithm.getAllContactManifolds(manifolds);
    for (int m = 0; m < manifolds.size(); ++m) {
      for (int k = 0; k < manifolds[m]->getNumContacts(); ++k) {
        if (manifolds[m]->getContactPoint(k).getDistance() <= 0) return true;
      }
    }
    return false;
  }
};

class BulletEngine : public Engine {
 public:
  explicit BulletEngine(const TriangleMesh& mesh)
      : vertices_(mesh.vertices.cast<float>()),
        triangles_(mesh.triangles),
        arrays_(static_cast<int>(triangles_.rows()), triangles_.data(), 3 * sizeof(std::int32_t),
                static_cast<int>(vertices_.rows()), vertices_.data(), 3 * sizeof(float)),
        shape_(&arrays_) {
    static_assert(sizeof(btScalar) == sizeof(float));
    shape_.setMargin(0);
    shape_.updateBound();
  }
  ~BulletEngine() override {
    for (btCollisionObject* object : present_) world_.removeCollisionObject(object);
  }

  std::string name() const override { return "bullet"; }

  std::vector<BodyPair> touching(const StepQuestion& question) override {
    std::vector<btCollisionObject*> present;
    for (const BodyPose& body : question.step.bodies) present.push_back(place(body));
    if (present != present_) {
      for (btCollisionObject* object : present_) world_.removeCollisionObject(object);
      for (btCollisionObject* object : present) world_.addCollisionObject(object);
      present_ = present;
    }
    dispatcher_.question = &question;
    dispatcher_.pairs.clear();
    world_.performDiscreteCollisionDetection();
    std::sort(dispatcher_.pairs.begin(), dispatcher_.pairs.end());
    return dispatcher_.pairs;
  }

 private:
  btCollisionObject* place(const BodyPose& body) {
    std::unique_ptr<btCollisionObject>& object = objects_[body.body];
    if (!object) {
      object = std::make_unique<btCollisionObject>();
      object->setCollisionFlags(0);  // static objects would be no pair
      object->setCollisionShape(&shape_);
    }
    const auto entry = [&](int i, int j) { return static_cast<btScalar>(body.pose(i, j)); };
    const btMatrix3x3 rotation(entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 0), entry(1, 1), entry(1, 2),
                               entry(2, 0), entry(2, 1), entry(2, 2));
    object->setWorldTransform(btTransform(rotation, btVector3(entry(0, 3), entry(1, 3), entry(2, 3))));
    object->setUserPointer(const_cast<BodyPose*>(&body));
    return object.get();
  }

  Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> vertices_;  // arrays_ points into both
  Triangles triangles_;
  btTriangleIndexVertexArray arrays_;
  btGImpactMeshShape shape_;
  btDefaultCollisionConfiguration configuration_;
  PairDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_{&dispatcher_, &broadphase_, &configuration_};
  std::map<std::int32_t, std::unique_ptr<btCollisionObject>> objects_;  // by body number; user pointer: its pose
  std::vector<btCollisionObject*> present_;                             // in world_
};

}  // namespace

std::unique_ptr<Engine> make_bullet_engine(const TriangleMesh& mesh) { return std::make_unique<BulletEngine>(mesh); }

}  // namespace encage::replay
