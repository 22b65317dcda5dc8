// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/energy/vertex_areas.h"

#include <Eigen/Geometry>

namespace encage {

Eigen::VectorXd vertex_areas(const TriangleMesh& mesh) {
  Eigen::VectorXd area = Eigen::VectorXd::Zero(mesh.vertices.rows());
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0);
    const double third = (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).norm() / 6;
    for (int k = 0; k < 3; ++k) area[mesh.triangles(t, k)] += third;
  }
  return area;
}

}  // namespace encage
