// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/shape.h>

class btGImpactMeshShape;
class btStridingMeshInterface;

namespace encage::bullet {

/// Properties of a GImpact mesh that decide where it may have contacts. World units, including the local scaling.
struct GImpactMesh {
  const btStridingMeshInterface* arrays = nullptr;
  double scale = 1;   ///< the same for all axes; 0 if axes differ
  double margin = 0;  ///< the largest of the parts
  double radius = 0;  ///< largest norm of a vertex
  /// `reach` is the largest distance of a point of a box in GImpact's tree from the triangle of the box. `spread` is
  /// the same for the box around that box, axis-aligned in any other frame.
  double reach = 0;
  double spread = 0;
  /// Each box is at most this much wider, to each side, than the box of the fine mesh's triangle of the same number,
  /// scaled. Infinite if there is no such triangle.
  double growth = 0;
  bool loose_vertices = false;  ///< some belong to no triangle; GImpact tests these too against planes
};

/// Measures the mesh. Throws Error as BulletAdapter::attach() documents.
GImpactMesh measure(const btGImpactMeshShape& mesh, const Shape& shape);

/// False if the margin or the scaling differ from the measured ones.
bool still_holds(const GImpactMesh& measured, const btGImpactMeshShape& mesh) noexcept;

}  // namespace encage::bullet
