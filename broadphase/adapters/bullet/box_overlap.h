// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

#include <Eigen/Geometry>

namespace encage::bullet {

/// A fine mesh, and by how much boxes of triangles are wider than the triangles to each side.
struct ENCAGE_HIDDEN BoxedMesh {
  const SimpleShape& shape;
  double scale;
  double growth;
};

/// False only if no box of a triangle of `a` and of `b`, axis-aligned in its body's frame, overlap by the test of their
/// six face normals, with all distances along these up to `slack` off. `b_to_a` is a rotation, then a translation. Re-
/// entrant, never allocates.
bool boxes_may_overlap(const BoxedMesh& a, const BoxedMesh& b, const Eigen::Isometry3d& b_to_a, double slack) noexcept;

}  // namespace encage::bullet
