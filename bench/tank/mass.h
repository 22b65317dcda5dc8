// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/error.h>
#include <encage/mesh.h>

namespace encage::tank {

/// A rigid body of unit density, in the frame of its mesh.
struct MassProperties {
  double mass = 0;                                     ///< the volume
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< of mass
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();   ///< tensor about the centre
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< principal frame -> frame of the mesh
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();   ///< principal moments, ascending
  double radius = 0;                                   ///< largest distance of a vertex from the centre
};

/// Exact integrals over the signed tetrahedra that the triangles span with a common point, summed in index order.
/// Throws Error if the mesh is not closed, not finite, or encloses no positive volume.
MassProperties mass_properties(const TriangleMesh& mesh);

}  // namespace encage::tank
