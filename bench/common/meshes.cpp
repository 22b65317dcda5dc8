// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/meshes.h"

#include "broadphase/shape/shape.h"

#include <encage/error.h>

#include <cstddef>
#include <cstdint>

namespace encage::bench {

TriangleMesh in_body_frame(const TriangleMesh& mesh, const Eigen::Vector3d& origin) {
  TriangleMesh moved = mesh;
  moved.vertices.rowwise() += origin.transpose();
  return moved;
}

TriangleMesh fine_mesh(const Shape& shape, const std::filesystem::path& file) {
  if (shape.is_compound() || shape.simple().fine.empty()) throw Error(file.string() + ": holds no fine mesh");
  const Surface& fine = shape.simple().fine;
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(fine.mesh.vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(fine.mesh.triangles.size()), 3);
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) mesh.vertices.row(v) = fine.vertex(v).transpose();
  for (std::int32_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      mesh.triangles(t, k) = static_cast<std::int32_t>(fine.mesh.triangles[static_cast<std::size_t>(t)][k]);
    }
  }
  return in_body_frame(mesh, shape.simple().frame.origin);
}

}  // namespace encage::bench
