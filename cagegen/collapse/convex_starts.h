// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/obstacle.h"

#include <encage/mesh.h>

namespace encage::makers {

// Convex surfaces around an obstacle, made of the vertices of `mesh`, which is the obstacle's surface or a part of it
// with the same convex hull. Vertices are exactly representable in float32. All three always succeed, also for flat and
// collinear meshes; none needs the mesh to be closed.

/// The convex hull, scaled or padded until it is clear of the obstacle; any number of triangles.
TriangleMesh hull_start(const Obstacle& obstacle, const TriangleMesh& mesh, double clearance);

/// An oriented box of about the smallest volume, hardly farther from the obstacle than the clearance; 12 triangles.
TriangleMesh box_start(const Obstacle& obstacle, const TriangleMesh& mesh, double clearance);

/// A tetrahedron; where a level may have fewer than 12 triangles.
TriangleMesh tetrahedron_start(const Obstacle& obstacle, const TriangleMesh& mesh, double clearance);

}  // namespace encage::makers
