// SPDX-License-Identifier: Apache-2.0
#pragma once

// How far apart are two bodies? Certified bounds, from cages or from the fine meshes.

#include <encage/export.h>
#include <encage/separated.h>

#include <Eigen/Core>

#include <cstdint>
#include <limits>

namespace ENCAGE_EXPORT encage {

struct CageDistanceOptions {
  /// World units, > 0: the query stops where its bound reaches this. Small values make it cheap.
  double enough = std::numeric_limits<double>::infinity();
  /// >= 0: the query may underestimate the distance of the cages by this part of it, which saves time.
  double tolerance = 0.01;
  /// The query asks cages from coarse to fine until the bound is `enough`; by default only the coarsest, which is the
  /// quickest and the loosest. Level 0 is the finest.
  int finest_cage = std::numeric_limits<int>::max();
  int coarsest_cage = std::numeric_limits<int>::max();
};

/// A lower bound, in world units, of the distance between two bodies at the start of their motions: never larger than
/// the distance, rounding included, and at most `enough`. It comes from the cages, or from balls around the bodies
/// where these give more. It is 0 where the bodies may touch or hold each other, and where a start is not usable.
/// Levels are paired as separated() pairs them. For compounds it is the least over all pairs of parts. Re-entrant;
/// never throws, never allocates, except that a ShapeCache may have to read a fine mesh.
double cage_distance_bound(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                           const CageDistanceOptions& options = {}) noexcept;

struct DistanceOptions {
  /// World units, > 0: the query does not look for larger distances.
  double limit = std::numeric_limits<double>::infinity();
  /// >= 0: the bounds may differ by this part of the distance, which saves time. 0.01 is usually enough.
  double tolerance = 0;
  /// Triangles of the fine meshes that may be near each other, e.g. the answer of the step before. A good hint saves
  /// time, and decides between pairs that are equally near. Out of range it is ignored.
  TrianglePair hint = {-1, -1};
};

struct DistanceResult {
  /// World units: lower <= distance <= upper. Both are 0 if the bodies are proven to touch, or one to hold a part of
  /// the other. Without tolerance they differ by rounding (some 1e-14 of the sizes of both bodies, their local origins
  /// and the difference of their translations) and by twice the CageHierarchy::fine_error of both bodies. They differ
  /// by more only next to degenerate triangles, and where `lower` is 0 because an unknown interior
  /// (Solid::surface_only) may hold the other body. `upper` is infinite if the distance is not below the limit.
  double lower = 0;
  double upper = std::numeric_limits<double>::infinity();
  /// Points of the fine meshes, in the world, that are `upper` apart or less. They are equal if one body holds a part
  /// of the other.
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
  /// The fine triangles on which the points lie, as CageHierarchy::fine counts them; -1 where the point is inside the
  /// body or the distance is not below the limit.
  std::int32_t triangle_a = -1, triangle_b = -1;
};

/// The distance between two bodies at the start of their motions: between the solids of closed and capped bodies, and
/// the surfaces of others. If one of them has no fine mesh, `lower` comes from their finest cages and `upper` is
/// infinite; if a start is not usable, they are 0 and infinite. Re-entrant; never throws, never allocates, except that
/// a ShapeCache may have to read a fine mesh.
DistanceResult distance(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                        const DistanceOptions& options = {}) noexcept;

}  // namespace encage
