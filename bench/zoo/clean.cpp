// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/clean.h"

#include "bench/zoo/intersections.h"
#include "cagegen/certify/connectivity.h"

namespace encage::zoo {

bool is_clean(const TriangleMesh& mesh) {
  if (mesh.triangles.rows() == 0) return false;
  for (const auto& t : mesh.triangles.rowwise()) {
    if (t(0) == t(1) || t(1) == t(2) || t(2) == t(0)) return false;
  }
  return proof::connectivity(mesh).defect.empty() && self_intersecting_triangles(mesh) == 0;
}

}  // namespace encage::zoo
