// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <Eigen/Core>

#include <vector>

namespace encage::handmade {

using Loop = std::vector<Eigen::Vector2d>;

/// Part of a plate's upper face that is moved: a pocket in the plate, a hole through it, or a leg on it.
struct Recess {
  Loop outline;       ///< counter-clockwise, inside the plate's, disjoint from the others
  double height = 0;  ///< of its floor: below the upper face a pocket, above it a leg; a hole where it is the lower one
};

/// A closed manifold, oriented outward: the prism over a polygon (counter-clockwise) from `low` to `high`, with
/// recesses in its upper face. No vertex is added.
TriangleMesh plate(const Loop& outline, double low, double high, const std::vector<Recess>& recesses = {});

Loop rectangle(double x0, double y0, double x1, double y1);
/// A regular polygon, its first corner in direction `turn` (a fraction of a full turn).
Loop regular(int corners, double radius, const Eigen::Vector2d& centre, double turn = 0);

TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// Splits edges at their middles until none is longer than `length`. A manifold stays one.
TriangleMesh refined(TriangleMesh mesh, double length);

/// All of them in one mesh; nothing is merged.
TriangleMesh together(const std::vector<TriangleMesh>& meshes);

}  // namespace encage::handmade
