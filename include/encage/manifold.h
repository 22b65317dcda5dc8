// SPDX-License-Identifier: Apache-2.0
#pragma once

// Contact points of two bodies that touch or are about to: what a rigid-body solver needs of a pair.

#include <encage/export.h>
#include <encage/shape.h>

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <span>

namespace ENCAGE_EXPORT encage {

struct ManifoldOptions {
  /// World units, >= 0. Points of surfaces that are apart by no more than this are reported too, so that contacts of
  /// resting bodies do not come and go.
  double margin = 0;
  /// World units, >= 0, usually 0: each body is its mesh and everything within this distance. A mesh of one degenerate
  /// triangle and a radius is a sphere or a capsule. Points lie on the rounded surfaces. The convex radius of a
  /// primitive counts in addition.
  double radius_a = 0, radius_b = 0;
  int most_points = 16;    ///< > 0, of a pair
  int most_per_patch = 4;  ///< > 0
};

struct ManifoldPoint {
  Eigen::Vector3d point_a =
      Eigen::Vector3d::Zero();  ///< world, on a's surface; in deep overlap maybe beside it, on a face's plane
  Eigen::Vector3d point_b = Eigen::Vector3d::Zero();  ///< on b's
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();   ///< world, unit length, from b towards a
  double separation = 0;                              ///< world units, along the normal; negative: depth
  std::uint64_t feature = 0;                          ///< the same for the same features in the next step
  std::int32_t patch = 0;                             ///< points with one number belong to one region of contact
};

/// Memory of one pair of bodies: what contact_manifold() works with, and the features of the step before. May be used
/// for another pair after clear(). Not for use by several threads at a time.
class ManifoldCache {
 public:
  ManifoldCache();
  ~ManifoldCache();
  ManifoldCache(const ManifoldCache& other);  ///< remembers the same
  ManifoldCache& operator=(const ManifoldCache& other);
  ManifoldCache(ManifoldCache&& other) noexcept;
  ManifoldCache& operator=(ManifoldCache&& other) noexcept;

  void clear() noexcept;

  class State;
  State& state() noexcept { return *state_; }

 private:
  std::unique_ptr<State> state_;
};

/// Fills in contact points of two bodies at the start of their motions, and returns how many there are. Surfaces that
/// come nearer to each other than the margin during the motion get points as well, whose separation tells how far the
/// bodies may approach (speculative contacts): pass the poses that the velocities lead to as the ends, or none with
/// Motion::resting(). Bodies turn the short way between them (Motion). Points of features that the step before reported
/// come first, in their order, then new ones. Every pair of bodies whose surfaces are nearer than the margin gets a
/// point; depths and directions of deep overlap are heuristic (docs/contacts.md).
///
/// Meshes that enclose a volume are solid. Contacts of open and hollow ones are those of their surface, two-sided.
/// Returns 0 if a body has no fine mesh, the margin or a radius is negative, or `points` is empty. Throws Error for a
/// motion that is not usable (is_usable()): a pose in float or one that mirrors, of which nothing is known; and if the
/// mesh of a ShapeCache cannot be read. The first call with a shape computes its features. Re-entrant with different
/// caches. Allocates only while the cache or the thread's working memory grows.
int contact_manifold(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                     const ManifoldOptions& options, ManifoldCache& cache, std::span<ManifoldPoint> points);

/// The same against a half-space; `point_b` lies on its plane.
int contact_manifold(const Shape& a, const Motion& motion_a, const HalfSpace& b, const ManifoldOptions& options,
                     ManifoldCache& cache, std::span<ManifoldPoint> points);

}  // namespace encage
