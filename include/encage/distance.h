// SPDX-License-Identifier: Apache-2.0
#pragma once

// Run time: how far apart are two bodies? Certified bounds, from cages or from the fine meshes.

#include <encage/export.h>
#include <encage/separated.h>

#include <Eigen/Core>

#include <cstdint>
#include <limits>

namespace ENCAGE_EXPORT encage {

struct CageDistanceOptions {
  /// World units: the bound is not followed beyond this. Small values make the query cheap.
  double enough = std::numeric_limits<double>::infinity();
  /// >= 0: the distance of the cages may be underestimated by this part of it, which saves time.
  double tolerance = 0.01;
  /// Cages are asked from coarse to fine until the bound is `enough`; by default only the coarsest, which is the
  /// quickest and the loosest.
  int finest_cage = std::numeric_limits<int>::max();
  int coarsest_cage = std::numeric_limits<int>::max();
};

/// Lower bound, in world units, of the distance of two bodies at the start of their motions: never larger than the
/// distance, rounding included; at most `enough`. It is that of the cages, or of balls around the bodies if that is
/// larger; 0 where bodies may touch or hold each other. With different numbers of levels, level k is paired as
/// separated() does. 0 if a start is not usable. Of compounds all parts are asked about. Re-entrant; never throws,
/// never allocates.
double cage_distance_bound(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                           const CageDistanceOptions& options = {}) noexcept;

struct DistanceOptions {
  /// World units: larger distances are not asked for.
  double limit = std::numeric_limits<double>::infinity();
  /// >= 0: the bounds may differ by this part of the distance, which saves time.
  double tolerance = 0;
  /// Triangles of the fine meshes that may be near each other, e.g. what the same query answered before: saves time,
  /// and decides between pairs that are equally near. Ignored where out of range.
  TrianglePair hint = {-1, -1};
};

struct DistanceResult {
  /// World units: lower <= distance <= upper. Both 0 if the bodies are proven to touch, or one to hold a part of the
  /// other. Without tolerance they differ by rounding, some 1e-14 of the sizes of both bodies, their local origins and
  /// the difference of their translations, and by what the fine meshes are off their sources
  /// (CageHierarchy::fine_error, twice for both bodies). More only next to degenerate triangles, and where `lower` is 0
  /// because an unknown interior may hold the other body (Solid::surface_only). `upper` is infinite if the distance is
  /// not below the limit.
  double lower = 0;
  double upper = std::numeric_limits<double>::infinity();
  /// World; points of the fine meshes that are `upper` apart or less. Equal if one body holds a part of the other.
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
  /// Fine triangles that have the points, as CageHierarchy::fine counts them; -1 where the point is inside the body, or
  /// the distance is not below the limit.
  std::int32_t triangle_a = -1, triangle_b = -1;
};

/// Distance of two bodies at the start of their motions: of the solids of closed and capped bodies, of the surfaces of
/// others. If one of them has no fine mesh, `lower` is that of their finest cages and `upper` infinite; if a start
/// is not usable, 0 and infinite. Re-entrant; never throws, never allocates.
DistanceResult distance(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                        const DistanceOptions& options = {}) noexcept;

}  // namespace encage
