// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/motion/pair_motion.h"
#include "broadphase/separation/triangle_pair.h"
#include "broadphase/shape/shape.h"

#include <algorithm>

namespace encage {

/// Positions of a triangle's corners at both ends of a step, in the common frame of a pair.
MovingTriangle moving_triangle(const ScaledSurface& surface, const std::array<AffineMap, 2>& maps,
                               const LeafTriangle& triangle) noexcept;

/// True only if the balls about the local origins that contain the surfaces are proven to stay farther apart than
/// `distance`.
bool balls_apart(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion, double distance) noexcept;

/// True only if every triangle of `a` is proven to stay farther than `distance` > 0 from every triangle of `b`, both as
/// computed in the common frame. `distance` has to cover rounding: required_distance(). Stops at the first pair without
/// proof, and where `steps`, if given, is negative: work takes from it as in visit_near_triangles().
bool surfaces_apart(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion, double distance,
                    std::int64_t* steps = nullptr) noexcept;

/// Amount of work spent on separating two moving triangles.
enum class Effort {
  quick,  ///< lanes_not_apart(); at large distances boxes are tested along the direction between them, too
  full,   ///< moving_triangles_apart()
};

/// Triangles of the fine meshes; returns false to stop.
using VisitTriangles = bool (*)(void* context, std::int32_t triangle_a, std::int32_t triangle_b);

/// Visits the pairs of triangles that are not proven to stay farther apart than `distance`, in a fixed order. Returns
/// false if a visitor stopped it. `steps`, if given, loses about as many as tests of one box against eight take the
/// same time; a visitor may take more from it. Where it is negative the visits stop, too.
bool visit_near_triangles(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion, double distance,
                          Effort effort, VisitTriangles visit, void* context, std::int64_t* steps = nullptr) noexcept;

/// Divides a step into intervals that are short enough for fixed axes to work well, leaves out those during which the
/// balls about the local origins are proven farther apart than `distance`, and calls visit(t0, t1) -> bool for the
/// others in order, until it returns false. Returns false if visit did.
template <class Visit>
bool visit_intervals(const ScaledSurface& a, const ScaledSurface& b, const PairMotion& motion, double distance,
                     Visit&& visit, double t0 = 0, double t1 = 1) {
  constexpr double shortest = 0x1p-8;
  const PairMotion part = motion.part(t0, t1);
  if (balls_apart(a, b, part, distance)) return true;
  const double longest_way = 0.25 * std::max(std::min(a.radius(), b.radius()), distance);
  if (t1 - t0 <= shortest || !(part.displacement(a.radius(), b.radius()) > longest_way)) return visit(t0, t1);
  const double middle = 0.5 * (t0 + t1);
  return visit_intervals(a, b, motion, distance, visit, t0, middle) &&
         visit_intervals(a, b, motion, distance, visit, middle, t1);
}

}  // namespace encage
