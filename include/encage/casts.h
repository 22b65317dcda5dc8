// SPDX-License-Identifier: Apache-2.0
#pragma once

// Casts: when a convex volume, or a moving body, first touches a body.

#include <encage/contact.h>
#include <encage/export.h>
#include <encage/queries.h>

#include <Eigen/Core>

#include <cstdint>
#include <span>

// Casts are re-entrant and never throw. They never allocate, except that a ShapeCache may have to read a fine mesh. The
// same calls give the same bits on every instruction set.
namespace ENCAGE_EXPORT encage {

enum class CastAnswer : std::uint8_t {
  miss,         ///< proven, rounding and CageHierarchy::fine_error included: nothing touches up to the end
  hit,          ///< they are apart, or just touch, at the start and come within rounding of each other at `time`
  overlapping,  ///< at the start they have points in common, by more than a touch; `time` is 0
  unknown,      ///< nothing is proven but that no contact is earlier than `time`
};

// ---- Volumes -------------------------------------------------------------------

struct CastOptions {
  /// False to meet the surface alone, as if the body were hollow: volumes may begin in a solid, and in the unknown
  /// interior of an open mesh (Solid::surface_only). What lies within the convex radius of a primitive's core overlaps
  /// it all the same.
  bool solid = true;
};

struct CastResult {
  CastAnswer answer = CastAnswer::unknown;
  /// In [0, 1], as a share of the translation. No contact is earlier; 1 of a miss. At the time of a hit the volume is
  /// within the rounding and twice CageHierarchy::fine_error of the triangle: the time is early by no more than it
  /// takes to come that much nearer.
  double time = 0;
  std::int32_t triangle = -1;  ///< of a hit, numbered as in CageHierarchy::fine
  /// Of a hit: a point of the triangle where the volume touches it, in the world. On triangles that are hardly more
  /// than a segment it may be another one of the triangle.
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  /// Of a hit: of unit length, from the body towards the volume. A volume that moves along it parts from the triangle.
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};

/// Finds when a volume that moves straight by `translation` (world units) first touches a body at the start of its
/// motion: Motion::resting(pose, scale) for one that rests. No contact is missed, and none begins before
/// CastResult::time. Rounding is 1e-13 S, S being the sum of |translation|, of the norm of the volume's points, of its
/// radius, and of the length of the body's translation and its scaled reach. A volume that passes the body within the
/// rounding may hit. Of several triangles that are hit at the same time the first in the mesh counts.
///
/// Solids are solid, as for overlaps(): a volume that begins inside a closed mesh overlaps at the start. One that just
/// touches at the start, with a normal that parts it from each triangle within rounding, hits at time 0; its motion
/// does not matter then. A translation of 0 is legal: a test of overlap. An open body (Solid::surface_only) has an
/// unknown interior: the answer is unknown from the time on at which the volume is in its box, unless options.solid is
/// false or the surface is crossed at the start.
///
/// A body without a fine mesh, or one whose mesh a ShapeCache cannot read, is what its finest cage encloses: a miss, or
/// unknown from the time on at which the volume touches the cage. The answer is unknown, with time 0, if the start pose
/// is not usable, a number is not finite or beyond 1e150, or a radius or a half size is negative.
CastResult cast(const Shape& shape, const Motion& motion, const Sphere& sphere, const Eigen::Vector3d& translation,
                const CastOptions& options = {}) noexcept;
CastResult cast(const Shape& shape, const Motion& motion, const Capsule& capsule, const Eigen::Vector3d& translation,
                const CastOptions& options = {}) noexcept;
CastResult cast(const Shape& shape, const Motion& motion, const OrientedBox& box, const Eigen::Vector3d& translation,
                const CastOptions& options = {}) noexcept;

/// The same for the convex hull of some points in the world, widened by `radius` >= 0. The points may be coplanar,
/// collinear or equal. No points have no hull, which misses everything. Tests of triangles take time proportional to
/// the number of points.
CastResult cast(const Shape& shape, const Motion& motion, std::span<const Eigen::Vector3d> hull, double radius,
                const Eigen::Vector3d& translation, const CastOptions& options = {}) noexcept;

// ---- Shapes --------------------------------------------------------------------

/// The first five are as in ContactOptions.
struct ShapeCastOptions {
  double margin = 0;                  ///< world units, >= 0; bodies within it touch
  double arc = 0;                     ///< world units, >= 0; with the sum of both bodies' arc_margin() for true arcs
  double latest = 1;                  ///< in [0, 1]; contacts that begin later are not looked for
  std::int64_t most_steps = 1 << 20;  ///< >= 0; the budget of work
  /// False to ask about surfaces alone, as if both bodies were hollow.
  bool solid = true;
};

struct ShapeCastResult {
  CastAnswer answer = CastAnswer::unknown;
  double time = 0;  ///< in [0, 1]: no contact begins earlier; 1 of a miss
  /// Of a hit, and of surfaces that are proven to cross at the start (Contact::overlapping).
  Contact contact;
  /// The budget of work ended (ShapeCastOptions::most_steps): the answer is unknown, unless bodies are proven to
  /// overlap.
  bool exhausted = false;
};

/// Finds when two moving bodies first touch: first_contact() for any start, and for solids. The answer is
///
/// * `miss` if the bodies are proven to be apart, and their surfaces not to touch up to options.latest;
/// * `overlapping` if at the start the surfaces are proven to cross, or a point of one body to lie in the other's
///   solid. One that lies inside without touching counts as well;
/// * `hit` otherwise, with the contact of first_contact(). Bodies that touch at the start, or are within the margin,
///   hit at time 0;
/// * `unknown` where nothing is proven but that no contact begins before `time`: where the budget of work ends; where
///   an unknown interior (Solid::surface_only) may hold the other body, unless options.solid is false; where
///   separated() proves nothing of a body without a fine mesh, or with one that a ShapeCache cannot read; if a motion
///   is not usable (is_usable()); and if an option is not finite, is negative or, options.latest, above 1.
///
/// Vertices move straight, and bodies turn the short way (Motion).
ShapeCastResult cast_shape(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                           const ShapeCastOptions& options = {}) noexcept;

}  // namespace encage
