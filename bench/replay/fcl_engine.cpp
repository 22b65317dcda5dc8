// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/fcl_engine.h"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <map>

namespace encage::replay {

struct FclEngine::Bodies {
  using Model = fcl::BVHModel<fcl::OBBRSSd>;

  struct Query {
    const CageGate* gate;
    std::vector<BodyPair> pairs;
  };

  std::shared_ptr<Model> model = std::make_shared<Model>();
  std::map<std::int32_t, std::unique_ptr<fcl::CollisionObjectd>> objects;  // by body number; user data: its key
  std::vector<fcl::CollisionObjectd*> present;                             // in `manager`
  fcl::DynamicAABBTreeCollisionManagerd manager;

  void place(const BodyPose& body) {
    std::unique_ptr<fcl::CollisionObjectd>& object = objects[body.body];
    if (!object) {
      object = std::make_unique<fcl::CollisionObjectd>(model);
      object->setUserData(const_cast<std::int32_t*>(&objects.find(body.body)->first));
    }
    object->setTransform(body.pose);
    object->computeAABB();
  }

  static bool visit(fcl::CollisionObjectd* a, fcl::CollisionObjectd* b, void* data) {
    Query& query = *static_cast<Query*>(data);
    if (query.gate && query.gate->separated(a->getTransform(), b->getTransform())) return false;
    const fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    if (fcl::collide(a, b, request, result) > 0) {
      const auto number = [](const fcl::CollisionObjectd* o) { return *static_cast<std::int32_t*>(o->getUserData()); };
      const auto [low, high] = std::minmax({number(a), number(b)});
      query.pairs.push_back({low, high});
    }
    return false;
  }
};

FclEngine::FclEngine(const TriangleMesh& mesh) : bodies_(std::make_unique<Bodies>()) {
  Bodies::Model& model = *bodies_->model;
  model.beginModel(static_cast<int>(mesh.triangles.rows()), static_cast<int>(mesh.vertices.rows()));
  std::vector<fcl::Vector3d> vertices;
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) vertices.push_back(mesh.vertex(v));
  std::vector<fcl::Triangle> triangles;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const auto corner = [&](int k) { return static_cast<std::size_t>(mesh.triangles(t, k)); };
    triangles.emplace_back(corner(0), corner(1), corner(2));
  }
  model.addSubModel(vertices, triangles);
  model.endModel();
}

FclEngine::~FclEngine() = default;

std::vector<BodyPair> FclEngine::touching(const PoseStep& step, const CageGate* gate) {
  std::vector<fcl::CollisionObjectd*> present;
  for (const BodyPose& body : step.bodies) {
    bodies_->place(body);
    present.push_back(bodies_->objects.at(body.body).get());
  }
  if (present != bodies_->present) {
    bodies_->manager.clear();
    bodies_->manager.registerObjects(present);
    bodies_->manager.setup();
    bodies_->present = present;
  } else {
    bodies_->manager.update(present);
  }
  Bodies::Query query{gate, {}};
  bodies_->manager.collide(&query, Bodies::visit);
  std::sort(query.pairs.begin(), query.pairs.end());
  return std::move(query.pairs);
}

}  // namespace encage::replay
