// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/encage.h>
#include <encage/fcl.h>

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/geometry/bvh/BVH_model.h>

#include <cstdio>
#include <memory>
#include <vector>

// The adapter for FCL, linked in whatever way: of three tetrahedra two touch, and the third lies in a corner of their
// bounding boxes.
int main() {
  encage::TriangleMesh mesh;
  mesh.vertices.resize(4, 3);
  mesh.vertices << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  encage::CageHierarchy hierarchy;
  hierarchy.fine = mesh;
  hierarchy.source_volume = 1.0 / 6;
  hierarchy.diagonal = 1.7320508075688772;

  const auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  std::vector<fcl::Vector3d> vertices;
  std::vector<fcl::Triangle> triangles;
  for (int i = 0; i < 4; ++i) {
    vertices.emplace_back(mesh.vertex(i));
    const auto corner = [&](int k) { return static_cast<std::size_t>(mesh.triangles(i, k)); };
    triangles.emplace_back(corner(0), corner(1), corner(2));
  }
  model->beginModel();
  model->addSubModel(vertices, triangles);
  model->endModel();

  encage::FclShapes shapes;
  shapes.attach(model, encage::make_shape(hierarchy));
  fcl::DynamicAABBTreeCollisionManagerd manager;
  std::vector<std::unique_ptr<fcl::CollisionObjectd>> objects;
  for (const double place : {0.0, 0.01, 0.6}) {
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.translation().setConstant(place);
    objects.push_back(std::make_unique<fcl::CollisionObjectd>(model, pose));
    manager.registerObject(objects.back().get());
  }
  manager.setup();

  // A callback that goes on searching after the first contact.
  int pairs = 0;
  encage::FclCollision collision(
      shapes,
      [](fcl::CollisionObjectd*, fcl::CollisionObjectd*, void* data) {
        ++*static_cast<int*>(data);
        return false;
      },
      &pairs);
  manager.collide(&collision, encage::FclCollision::callback);
  const auto rejected = static_cast<int>(collision.statistics().rejected);

  bool caught = false;
  try {
    shapes.attach(nullptr, nullptr);
  } catch (const encage::Error&) {
    caught = true;
  }
  std::printf("Encage with FCL: pairs left %d, rejected %d, error caught %d\n", pairs, rejected, caught);
  return pairs == 1 && rejected == 2 && caught ? 0 : 1;
}
