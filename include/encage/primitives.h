// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spheres, capsules, boxes, cylinders and convex hulls as shapes.

#include <encage/export.h>
#include <encage/shape.h>

#include <Eigen/Core>

#include <span>

// A primitive is a shape like any other: for separated(), candidates, distance(), first_contact(), contact_manifold(),
// queries, World and compounds, against meshes and other primitives. It is solid and convex. Its body is a *core*, a
// small mesh, with all points within its *convex radius* of that and of what it encloses. The core of a sphere is a
// point, that of a capsule a segment, each as one degenerate triangle; boxes, cylinders and most hulls are their core.
// Numbers of triangles and vertices, fine_mesh() and fine_error() are about the core. docs/primitives.md says what each
// function promises.
//
// Lengths are in units of the body frame, which a scale multiplies. Sizes have to be between 1e-30 and 1e37, and so
// have coordinates to be below 1e37; every function throws Error, which names argument and value, for others. Nothing
// is shared between calls: any thread may make primitives.
namespace ENCAGE_EXPORT encage {

/// Makes the ball of this radius about the origin.
ShapePtr make_sphere(double radius);

/// Makes the body of all points within the radius of the segment from `a` to `b`, which may be one point.
ShapePtr make_capsule(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double radius);

/// Makes a capsule along y, as Jolt and Bullet do: its segment goes from -half_length to half_length >= 0.
ShapePtr make_capsule(double half_length, double radius);

/// Makes the box of the points with |x_k| <= half_k. Exact if the half sizes are float32, else up to the fine_error().
ShapePtr make_box(const Eigen::Vector3d& half);

/// Makes a cylinder along y, as Jolt and Bullet do, with |y| <= half_height. Its mesh is a prism of 3 to 4096 sides
/// half way between the inscribed and the circumscribed one; fine_error() covers the rest, about
/// radius * 2.5 / sides^2: 0.0006 of the radius for 64 sides. Whoever adds fine_error() adds this.
ShapePtr make_cylinder(double half_height, double radius, int sides = 64);

/// Makes the convex hull of some points, widened by `radius` >= 0. The mesh has the extreme points as its vertices
/// (Barber et al. 1996, "The quickhull algorithm for convex hulls"); what rounding makes it lose, fine_error() covers.
/// Points that lie within 1e-6 of their extent of a plane have no hull that is a solid: that is an error if the radius
/// is 0; widened, they are a sphere, a capsule or a rounded plate. The order of triangles and vertices depends on the
/// points alone. Takes O(n log n) for most sets of n points.
ShapePtr make_convex_hull(std::span<const Eigen::Vector3d> points, double radius = 0);

/// Returns the convex radius, in units of the body frame: 0 for meshes, boxes, cylinders and hulls without one; for a
/// compound the largest of its parts'.
double convex_radius(const Shape& shape) noexcept;

}  // namespace encage
