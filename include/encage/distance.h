// SPDX-License-Identifier: Apache-2.0
#pragma once

// Certified bounds of the distance between two bodies, from cages or from the fine meshes, and of the distance of a
// body to a half-space.

#include <encage/export.h>
#include <encage/separated.h>

#include <Eigen/Core>

#include <cstdint>
#include <limits>

namespace ENCAGE_EXPORT encage {

struct CageDistanceOptions {
  /// World units, > 0, usually infinite. The query stops as soon as its bound reaches this; small values make it fast.
  double enough = std::numeric_limits<double>::infinity();
  /// >= 0, usually 0.01. The query may underestimate the distance of the cages by this fraction, which saves time.
  double tolerance = 0.01;
  /// The query tests cages from coarse to fine until the bound reaches `enough`. By default it tests only the coarsest
  /// level, which is the fastest and the loosest. Level 0 is the finest.
  int finest_cage = std::numeric_limits<int>::max();
  int coarsest_cage = std::numeric_limits<int>::max();
  std::int64_t most_steps = 1 << 20;  ///< as in DistanceOptions; a query that ends with it returns a smaller bound
};

/// Returns a lower bound, in world units, of the distance between two bodies at the start of their motions: never
/// larger than the distance, rounding included, and at most `enough`. It comes from the cages, or from bounding balls
/// of the bodies where these give more. It is 0 where the bodies may touch or one may contain the other, and where a
/// start pose is not usable. Levels are paired as in separated(); a primitive stands for its cages. For compounds it is
/// the minimum over all pairs of parts. Re-entrant; never throws, never allocates, except that a ShapeCache may have to
/// read a fine mesh.
double cage_distance_bound(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                           const CageDistanceOptions& options = {}) noexcept;

struct DistanceOptions {
  /// World units, > 0, usually infinite. The query does not look for larger distances.
  double limit = std::numeric_limits<double>::infinity();
  /// >= 0; 0.01 is usually accurate enough. The bounds may differ by this fraction of the distance, which saves time.
  double tolerance = 0;
  /// Triangles of the fine meshes that may be near each other, e.g. the result of the step before. A good hint saves
  /// time, and it decides between pairs that are equally near. The query ignores a hint that is out of range.
  TrianglePair hint = {-1, -1};
  /// >= 0. Budget of work: a step is about the test of a box against eight, some 50 to 100 ns. The number of steps that
  /// a query takes depends on its arguments alone.
  std::int64_t most_steps = 1 << 20;
};

struct DistanceResult {
  /// World units: lower <= distance <= upper. Both are 0 if it is proven that the bodies touch or that one contains a
  /// part of the other. Without tolerance they differ by rounding (some 1e-14 of the sizes of both bodies, their local
  /// origins and the difference of their translations) and by twice the CageHierarchy::fine_error of both bodies, and
  /// by 2e-8 of the convex radii of primitives, for which the tolerance is 0. They differ by more only next to
  /// degenerate triangles, and where `lower` is 0 because an unknown interior (Solid::surface_only) may contain the
  /// other body. `upper` is infinite if the distance is not below the limit.
  double lower = 0;
  double upper = std::numeric_limits<double>::infinity();
  /// Points of the fine meshes, in world coordinates, that are at most `upper` apart; of primitives with a convex
  /// radius points of their surfaces. They are equal if one body contains a part of the other.
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
  /// The fine triangles that contain these points, or are nearest to them in a core, numbered as in
  /// CageHierarchy::fine; -1 where the point is inside the body or the distance is not below the limit.
  std::int32_t triangle_a = -1, triangle_b = -1;
  /// The query reached the end of its budget of work (DistanceOptions::most_steps), as happens where very many
  /// triangles are equally near. The bounds hold, but may differ by more than is said above.
  bool exhausted = false;
};

/// Computes the distance between two bodies at the start of their motions (their ends do not count): between the solids
/// of closed and capped bodies, and the surfaces of others. If one of them has no fine mesh, `lower` comes from their
/// finest cages and `upper` is infinite. If a start pose is not usable, they are 0 and infinite. Re-entrant; never
/// throws, never allocates, except that a ShapeCache may have to read a fine mesh.
DistanceResult distance(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                        const DistanceOptions& options = {}) noexcept;

struct PlaneDistanceOptions {
  /// World units, of any sign, usually infinite. The query does not look for larger distances.
  double limit = std::numeric_limits<double>::infinity();
};

/// The distance of a body to a half-space: negative where the body reaches into it, and then the depth of its deepest
/// vertex below the plane.
struct PlaneDistance {
  /// World units: lower <= distance <= upper. They differ by rounding (some 1e-14 of the body's size, its distance from
  /// the world's origin and the half-space's offset) and by twice the CageHierarchy::fine_error. Without a fine mesh
  /// `lower` comes from the finest cage and `upper` is infinite. `upper` is infinite, too, if the distance is not below
  /// the limit.
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  /// World coordinates: the lowest vertex of the fine mesh, and its foot on the plane.
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), foot = Eigen::Vector3d::Zero();
  /// This vertex, numbered as in CageHierarchy::fine, through all parts of a compound: the first one of equally low
  /// ones. -1 if there is no fine mesh or the distance is not below the limit.
  std::int32_t vertex = -1;
};

/// Computes the distance between a body at the start of its motion (the end does not count) and a half-space. If the
/// start pose is not usable, the normal's length is not 1 within 1e-9, or a number is not finite, the bounds are minus
/// and plus infinity. Takes a time that grows as the logarithm of the number of triangles, more where many are equally
/// low. Re-entrant; never throws, never allocates, except that a ShapeCache may have to read a fine mesh.
PlaneDistance distance(const Shape& shape, const Motion& motion, const HalfSpace& half_space,
                       const PlaneDistanceOptions& options = {}) noexcept;

}  // namespace encage
