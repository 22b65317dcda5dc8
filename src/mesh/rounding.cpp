// SPDX-License-Identifier: Apache-2.0
#include "src/mesh/rounding.h"

#include <algorithm>

namespace encage {

Eigen::Vector3d round_to_float(const Eigen::Vector3d& p) {
  // The volatile is needed because g++ 12.2 at -O2 drops the conversion of two of three lanes.
  volatile float x = static_cast<float>(p.x());
  volatile float y = static_cast<float>(p.y());
  volatile float z = static_cast<float>(p.z());
  return {x, y, z};
}

double round_vertices(TriangleMesh& mesh) {
  double farthest = 0;
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
    const Eigen::Vector3d before = mesh.vertex(v), rounded = round_to_float(before);
    mesh.vertices.row(v) = rounded.transpose();
    farthest = std::max(farthest, (rounded - before).norm());
  }
  return farthest * (1 + 1e-12);  // the norm itself is rounded
}

}  // namespace encage
