// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/rounding.h"

namespace encage::makers {

Point round_to_float(const Point& p) {
  // Through volatile: g++ 12.2 at -O2 drops the conversion of two of three lanes.
  volatile float x = static_cast<float>(p.x());
  volatile float y = static_cast<float>(p.y());
  volatile float z = static_cast<float>(p.z());
  return {x, y, z};
}

void round_vertices(TriangleMesh& mesh) {
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    mesh.vertices.row(v) = round_to_float(mesh.vertex(static_cast<std::int32_t>(v))).transpose();
  }
}

}  // namespace encage::makers
