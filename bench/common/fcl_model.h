// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <fcl/geometry/bvh/BVH_model.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace encage::bench {

/// FCL's tree over a mesh.
template <class Volume>
std::shared_ptr<fcl::BVHModel<Volume>> make_fcl_model(const TriangleMesh& mesh) {
  auto model = std::make_shared<fcl::BVHModel<Volume>>();
  model->beginModel(static_cast<int>(mesh.triangles.rows()), static_cast<int>(mesh.vertices.rows()));
  std::vector<fcl::Vector3<typename Volume::S>> vertices;
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) vertices.push_back(mesh.vertex(v).cast<typename Volume::S>());
  std::vector<fcl::Triangle> triangles;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const auto corner = [&](int k) { return static_cast<std::size_t>(mesh.triangles(t, k)); };
    triangles.emplace_back(corner(0), corner(1), corner(2));
  }
  model->addSubModel(vertices, triangles);
  model->endModel();
  return model;
}

}  // namespace encage::bench
