// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/shape.h>

class btGImpactMeshShape;
class btStridingMeshInterface;

namespace encage::bullet {

/// What of a GImpact mesh decides where it may have contacts. World units, the local scaling included.
struct GImpactMesh {
  const btStridingMeshInterface* arrays = nullptr;
  double scale = 1;   ///< of all axes alike; 0: of each another
  double margin = 0;  ///< the largest of the parts
  double radius = 0;  ///< largest norm of a vertex
  /// Boxes of triangles in GImpact's tree. `reach`: largest distance of a point of a box from its triangle. `spread`:
  /// the same for the box about that box, axis-aligned in any other frame.
  double reach = 0;
  double spread = 0;
  /// Boxes are no wider than those of the fine mesh's triangles of the same number, scaled, by more than this to each
  /// side; infinite if there is no such triangle.
  double growth = 0;
  bool loose_vertices = false;  ///< some are not of a triangle; against planes GImpact looks at these too
};

/// Measures the mesh. Throws Error where BulletAdapter::attach() says so.
GImpactMesh measure(const btGImpactMeshShape& mesh, const Shape& shape);

/// False if margin or scaling are not those that were measured.
bool still_holds(const GImpactMesh& measured, const btGImpactMeshShape& mesh) noexcept;

}  // namespace encage::bullet
