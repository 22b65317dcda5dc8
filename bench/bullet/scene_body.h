// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <Eigen/Geometry>

namespace encage::bullet_bench {

/// A mesh as a rigid body of mass 1: engines take the origin for the centre of mass and the axes for the principal
/// ones.
struct SceneBodyModel {
  explicit SceneBodyModel(const TriangleMesh& mesh);

  TriangleMesh mesh;        ///< in the body frame
  Eigen::Isometry3d frame;  ///< body frame -> frame of the mesh as it was given
  Eigen::Vector3d moments;  ///< of inertia
  double radius = 0;        ///< largest distance of a vertex from the centre of mass
};

}  // namespace encage::bullet_bench
