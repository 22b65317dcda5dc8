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

/// Requirements on two meshes beyond a distance larger than both margins and all rounding.
struct PairQuestion {
  double extra = 0;             ///< distance beyond the margins
  bool false_contacts = false;  ///< GImpact's contacts of triangles back to back count as contacts
};

/// True only if Bullet has no contact between the two (docs/guarantee.md, "Bullet").
bool proven_apart(const AttachedMesh& a, const btTransform& transform_a, const AttachedMesh& b,
                  const btTransform& transform_b, const PairQuestion& question) noexcept;

/// The same for a static plane.
bool proven_apart(const AttachedMesh& a, const btTransform& transform_a, const btStaticPlaneShape& plane,
                  const btTransform& transform_plane, double extra) noexcept;

}  // namespace encage::bullet
