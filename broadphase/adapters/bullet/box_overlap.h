// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

#include <Eigen/Geometry>

namespace encage::bullet {

/// A fine mesh, and how much wider on each side the boxes of its triangles are than the triangles.
struct ENCAGE_HIDDEN BoxedMesh {
  const SimpleShape& shape;
  double scale;
  double growth;
};

/// False only if no boxes of a triangle of `a` and one of `b`, each axis-aligned in its body's frame, overlap by the
/// test of their six face normals, where all distances along these may be off by `slack`. `b_to_a` is a rotation
/// followed by a translation. Re-entrant, never allocates.
bool boxes_may_overlap(const BoxedMesh& a, const BoxedMesh& b, const Eigen::Isometry3d& b_to_a, double slack) noexcept;

}  // namespace encage::bullet
