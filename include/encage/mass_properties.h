// SPDX-License-Identifier: Apache-2.0
#pragma once

// Volume, centre and inertia of the body that a closed mesh encloses.

#include <encage/error.h>
#include <encage/export.h>
#include <encage/mesh.h>

namespace ENCAGE_EXPORT encage {

class Shape;

/// A rigid body of unit density, in the frame of its mesh. Scale by density; a body s times as large has s^3 times the
/// mass and s^5 times the moments.
struct MassProperties {
  double mass = 0;                                     ///< the volume
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< of mass
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();   ///< tensor about the centre
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< principal frame -> frame of the mesh
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();   ///< principal moments, ascending
  double radius = 0;  ///< largest distance of a vertex from the centre; of a primitive at least that of a point
};

/// Exact integrals over the signed tetrahedra that the triangles span with a common point, summed in index order.
/// Regions that the surface encloses twice count twice. Throws Error if the mesh is not closed, not finite, or encloses
/// no positive volume.
MassProperties mass_properties(const TriangleMesh& mesh);

/// The same of a shape, in the body frame, from its fine mesh in place (float32, caps included). Those of
/// primitives come from formulas for the body that was meant. The parts of a compound are summed, so that where they
/// overlap counts twice. Throws Error if a part has no fine mesh, is not closed, is a convex hull with a radius, or, in
/// the whole, encloses no positive volume, and if the mesh of a ShapeCache cannot be read. Linear time; for a program
/// that links encage::broadphase.
MassProperties mass_properties(const Shape& shape);

}  // namespace encage
