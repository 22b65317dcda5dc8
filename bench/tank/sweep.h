// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/broadphase.h>
#include <encage/mesh.h>

namespace encage::tank {

/// A mesh during one step: every vertex on the straight line between two places
/// in the world. What the trees that are rebuilt in every step are built over.
struct Sweep {
  const TriangleMesh* mesh = nullptr;  ///< not owned
  Eigen::Isometry3d start, end;        ///< frame of the mesh to the world
  /// World units: by how much bounding volumes have to be larger than what they bound.
  double slack = 0;

  Eigen::Vector3d start_of(std::int32_t v) const { return start * mesh->vertex(v); }
  Eigen::Vector3d end_of(std::int32_t v) const { return end * mesh->vertex(v); }
};

/// `mesh` is the fine mesh of a hierarchy with this origin. Two triangles that come closer than `distance`,
/// as the narrow phase computes it, have overlapping bounding volumes: slack is half of
/// it and 2^-40 of the coordinates' size (rounding here stays below 2^-48 of it, and the
/// narrow phase adds 2^-46). `mesh` has to outlive the result.
Sweep make_sweep(const TriangleMesh& mesh, const Eigen::Vector3d& origin, const Motion& motion, double distance);

/// A float that is not below x, and by little more than a rounding above it.
inline float float_above(double x) { return static_cast<float>(x + (x < 0 ? -x : x) * 0x1p-23 + 1e-44); }

}  // namespace encage::tank
