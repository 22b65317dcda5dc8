// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/fcl_engine.h"

#include "bench/common/fcl_model.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <map>
#include <type_traits>
#include <utility>

namespace encage::replay {
namespace {

template <class Volume>
class FclEngine : public Engine {
 public:
  using Scalar = typename Volume::S;
  using Object = fcl::CollisionObject<Scalar>;

  FclEngine(const TriangleMesh& mesh, std::string name)
      : name_(std::move(name)), model_(bench::make_fcl_model<Volume>(mesh)) {}

  std::string name() const override { return name_; }

  std::vector<BodyPair> touching(const StepQuestion& question) override {
    std::vector<Object*> present;
    for (const BodyPose& body : question.step.bodies) present.push_back(place(body));
    if (present != present_) {
      manager_.clear();
      manager_.registerObjects(present);
      manager_.setup();
      present_ = present;
    } else {
      manager_.update(present);
    }
    FclQuery query{question, {}};
    manager_.collide(&query, visit);
    std::sort(query.pairs.begin(), query.pairs.end());
    return std::move(query.pairs);
  }

 private:
  struct FclQuery {
    const StepQuestion& question;
    std::vector<BodyPair> pairs;
  };

  Object* place(const BodyPose& body) {
    std::unique_ptr<Object>& object = objects_[body.body];
    if (!object) object = std::make_unique<Object>(model_);
    object->setUserData(const_cast<BodyPose*>(&body));
    object->setTransform(body.pose.cast<Scalar>());
    object->computeAABB();
    return object.get();
  }

  static bool visit(Object* a, Object* b, void* data) {
    FclQuery& query = *static_cast<FclQuery*>(data);
    const BodyPose& body_a = *static_cast<const BodyPose*>(a->getUserData());
    const BodyPose& body_b = *static_cast<const BodyPose*>(b->getUserData());
    if (query.question.skips(body_a, body_b)) return false;
    if (collide(*a, *b)) query.pairs.push_back(make_pair(body_a.body, body_b.body));
    return false;
  }

  static bool collide(const Object& a, const Object& b) {
    const fcl::CollisionRequest<Scalar> request;
    fcl::CollisionResult<Scalar> result;
    if constexpr (std::is_same_v<Scalar, double>) {
      return fcl::collide(&a, &b, request, result) > 0;
    } else {
      // What fcl::collide() does with two such meshes. The library has it for double only, and all shapes take long to
      // compile.
      return fcl::detail::BVHCollide<Volume>(a.collisionGeometry().get(), a.getTransform(), b.collisionGeometry().get(),
                                             b.getTransform(), request, result) > 0;
    }
  }

  std::string name_;
  std::shared_ptr<fcl::BVHModel<Volume>> model_;
  std::map<std::int32_t, std::unique_ptr<Object>> objects_;  // by body number; user data: its pose
  std::vector<Object*> present_;                             // in manager_
  fcl::DynamicAABBTreeCollisionManager<Scalar> manager_;
};

}  // namespace

std::unique_ptr<Engine> make_fcl_engine(const TriangleMesh& mesh, FclVolume volume) {
  switch (volume) {
    case FclVolume::obb: return std::make_unique<FclEngine<fcl::OBBd>>(mesh, "fcl_obb");
    case FclVolume::obbrss_float: return std::make_unique<FclEngine<fcl::OBBRSSf>>(mesh, "fcl_float");
    default: return std::make_unique<FclEngine<fcl::OBBRSSd>>(mesh, "fcl");
  }
}

}  // namespace encage::replay
