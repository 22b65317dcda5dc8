// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/adapters/bullet/gimpact_mesh.h"

class btStaticPlaneShape;
class btTransform;

namespace encage::bullet {

struct AttachedMesh {
  ShapePtr shape;
  GImpactMesh mesh;
};

/// True only if Bullet has no contact between the two: they are farther apart than both margins, `extra`, and all
/// rounding (docs/guarantee.md, "Bullet"); with `boxes` also too far for boxes of triangles to overlap.
bool proven_apart(const AttachedMesh& a, const btTransform& transform_a, const AttachedMesh& b,
                  const btTransform& transform_b, double extra, bool boxes) noexcept;

/// The same for a static plane.
bool proven_apart(const AttachedMesh& a, const btTransform& transform_a, const btStaticPlaneShape& plane,
                  const btTransform& transform_plane, double extra) noexcept;

}  // namespace encage::bullet
