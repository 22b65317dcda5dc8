// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace encage::io {

// CGAL's exact predicates on doubles, compiled once: its headers are slow to compile.

/// +1 if c lies to the left of the line from a to b, -1 if to the right, 0 if on it.
int orientation(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);
/// +1 if d lies on the side of the plane from which a, b, c run counter-clockwise, -1 on the other, 0 on the plane; the
/// signs are those of CGAL, the determinant of b - a, c - a and d - a.
int orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d);
bool collinear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
/// Of collinear points: b lies strictly between a and c.
bool strictly_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace encage::io
