// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/obstacle.h"

#include <encage/mesh.h>

#include <Eigen/Core>

#include <vector>

namespace encage::makers {

/// The vertices of a mesh's convex hull, and the axes of a small box around them. The mesh need not be closed, and may
/// be flat or collinear.
struct ConvexFrame {
  ConvexFrame(const TriangleMesh& mesh, double clearance);

  std::vector<Point> points;
  Eigen::Matrix3d axes;  ///< rows; from the mesh's coordinates to those along the box
};

// Convex surfaces around an obstacle, made of the frame of its surface, or of a part of that with the same convex hull.
// Vertices are exactly representable in float32. All three always succeed.

/// The convex hull, scaled or padded until it is clear of the obstacle; any number of triangles.
TriangleMesh hull_start(const Obstacle& obstacle, const ConvexFrame& frame, double clearance);

/// An oriented box of about the smallest volume, hardly farther from the obstacle than the clearance; 12 triangles.
TriangleMesh box_start(const Obstacle& obstacle, const ConvexFrame& frame, double clearance);

/// A tetrahedron; where a level may have fewer than 12 triangles.
TriangleMesh tetrahedron_start(const Obstacle& obstacle, const ConvexFrame& frame, double clearance);

}  // namespace encage::makers
