// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <Eigen/Core>

#include <optional>
#include <span>

namespace encage::makers {

/// Convex hull of finite points, outward; exact. Its vertices are the extreme points in lexicographic order, its faces
/// fans of the hull's facets, so that it depends on the set of points alone (that of CGAL depends on addresses where
/// more than three points are coplanar). No value if it is flat.
std::optional<TriangleMesh> convex_hull(std::span<const Eigen::Vector3d> points);

/// Axes of a box around finite points that has about the smallest volume, as rows. CGAL's genetic search, from a fixed
/// seed: the same for the same points. For at least four points that do not lie in a plane.
Eigen::Matrix3d smallest_box_axes(std::span<const Eigen::Vector3d> points);

}  // namespace encage::makers
