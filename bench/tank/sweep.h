// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>
#include <encage/shape.h>

namespace encage::tank {

/// The fine mesh of a hierarchy, in its local frame, and what it takes to move it.
struct BodyMesh {
  BodyMesh(TriangleMesh fine, const Eigen::Vector3d& local_origin);

  TriangleMesh mesh;
  Eigen::Vector3d origin;  ///< body frame = origin + local frame
  double radius = 0;       ///< no vertex is farther from the local origin

  /// By how much bounding volumes have to be larger than what they bound if those of two triangles that come closer
  /// than `distance`, as the narrow phase computes it, have to overlap: half of it, and 2^-40 of the coordinates' size
  /// (rounding here stays below 2^-48 of it, and the narrow phase adds 2^-46).
  double slack(const Motion& motion, double distance) const;
};

/// A mesh during one step: every vertex on the straight line between two positions in the world. What the trees that
/// are rebuilt in every step are built over.
struct Sweep {
  const TriangleMesh* mesh = nullptr;  ///< not owned
  Eigen::Isometry3d start, end;        ///< frame of the mesh to the world
  double slack = 0;                    ///< world units: bounding volumes are larger by this on all sides

  Eigen::Vector3d start_of(std::int32_t v) const { return start * mesh->vertex(v); }
  Eigen::Vector3d end_of(std::int32_t v) const { return end * mesh->vertex(v); }
};

/// With BodyMesh::slack(); `body` has to outlive the result.
Sweep make_sweep(const BodyMesh& body, const Motion& motion, double distance);

/// A float that is not below x, and by little more than a rounding above it.
inline float float_above(double x) { return static_cast<float>(x + (x < 0 ? -x : x) * 0x1p-23 + 1e-44); }

}  // namespace encage::tank
