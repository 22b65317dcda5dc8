// SPDX-License-Identifier: Apache-2.0
#include "broadphase/distance/resting_pair.h"
#include "broadphase/distance/surface_distance.h"
#include "broadphase/motion/pose.h"
#include "broadphase/separation/containment.h"
#include "broadphase/shape/compound.h"
#include "broadphase/shape/world_box.h"

#include <encage/distance.h>
#include <encage/fine_lease.h>

#include <algorithm>
#include <cmath>

namespace encage {
namespace {

/// Lower bound from the balls around the local origins, which contain the bodies, unknown interiors included.
double ball_bound(const SimpleShape& a, const SimpleShape& b, const RestingPair& pair, double error) {
  const double reach = (pair.scale_a * a.outer().radius + pair.scale_b * b.outer().radius) * (1 + 1e-8);
  return std::max(0.0, pair.b.offset.norm() - reach - error);
}

/// Decides, for two bodies whose surfaces are apart, whether one may contain a part of the other.
class Containment {
 public:
  Containment(const SimpleShape& a, const SimpleShape& b, const RestingPair& pair) : a_(a), b_(b), pair_(pair) {}

  /// True if an unknown interior may contain a part of the other body.
  bool possible(bool open_a, bool open_b) const {
    if (!open_a && !open_b) return false;
    FineLease lease_a, lease_b;
    if (!lease_a.take(a_) || !lease_b.take(b_)) return true;
    const std::array<AffineMap, 2> maps_a = {pair_.a, pair_.a}, maps_b = {pair_.b, pair_.b};
    return (open_a && could_hold(a_, pair_.scale_a, maps_a, b_, pair_.scale_b, maps_b, pair_.located())) ||
           (open_b && could_hold(b_, pair_.scale_b, maps_b, a_, pair_.scale_a, maps_a, pair_.located()));
  }

  bool excluded(const ScaledSurface& surface_a, const ScaledSurface& surface_b) const {
    return (flat_core(a_) || all_outside(surface_a, surface_b, pair_.b_to_a())) &&
           (flat_core(b_) || all_outside(surface_b, surface_a, pair_.a_to_b()));
  }

 private:
  const SimpleShape& a_;
  const SimpleShape& b_;
  const RestingPair& pair_;
};

double error_in_world(const SimpleShape& a, const SimpleShape& b, const RestingPair& pair) {
  return a.error_in_world(pair.scale_a) + b.error_in_world(pair.scale_b);
}

/// The same of cores.
double core_error_in_world(const SimpleShape& a, const SimpleShape& b, const RestingPair& pair) {
  return a.core_error_in_world(pair.scale_a) + b.core_error_in_world(pair.scale_b);
}

/// cage_distance_bound() of simple shapes.
double cage_bound(const SimpleShape& a, const SimpleShape& b, const RestingPair& pair,
                  const CageDistanceOptions& options, std::int64_t& steps) {
  double bound = ball_bound(a, b, pair, error_in_world(a, b, pair) + pair.error);
  if (a.level(0) == nullptr || b.level(0) == nullptr || bound >= options.enough) return bound;
  const Containment containment(a, b, pair);
  if (containment.possible(unknown_in_cage(a), unknown_in_cage(b))) return bound;
  const int last = std::max({level_count(a), level_count(b), 1}) - 1;
  const double beyond = a.beyond_level(pair.scale_a) + b.beyond_level(pair.scale_b);
  for (int k = std::min(options.coarsest_cage, last); k >= std::clamp(options.finest_cage, 0, last); --k) {
    const ScaledSurface cage_a(*a.level(k), pair.scale_a), cage_b(*b.level(k), pair.scale_b);
    const SurfaceDistance found = surface_distance(
        cage_a, cage_b, pair, {.limit = options.enough + beyond, .tolerance = options.tolerance, .steps = &steps});
    // Containment is decided only if the surfaces are farther apart than the error of a located point.
    if (found.lower > std::max(bound, pair.located()) + beyond && containment.excluded(cage_a, cage_b)) {
      bound = found.lower - beyond;
    }
    if (bound >= options.enough) break;
  }
  return bound;
}

/// Returns the vertex that stands for a part of `guest` in `host`'s solid, or -1.
std::int32_t held_vertex(const ScaledSurface& host, const ScaledSurface& guest, const AffineMap& to_host,
                         bool& unknown) {
  for (const MeshPart& part : guest->parts) {
    const Side side = locate(*host, to_host(guest.vertex(part.vertex)) / host.scale());
    if (side == Side::inside) return part.vertex;
    unknown = unknown || side == Side::unknown;
  }
  return -1;
}

std::int32_t triangle_of(const Surface& surface, std::int32_t vertex) {
  const auto& triangles = surface.mesh.triangles;
  const auto found = std::find_if(triangles.begin(), triangles.end(), [&](const auto& t) {
    return std::find(t.begin(), t.end(), static_cast<std::uint32_t>(vertex)) != t.end();
  });
  return static_cast<std::int32_t>(found - triangles.begin());
}

/// Decides whether a part of one body is inside the other. Surfaces must be farther apart than the error of a located
/// point.
void look_inside(const SimpleShape& a, const SimpleShape& b, const RestingPair& pair, DistanceResult& result) {
  const Interior in_a = interior(a), in_b = interior(b);
  const ScaledSurface fine_a(a.fine, pair.scale_a), fine_b(b.fine, pair.scale_b);
  bool unknown = Containment(a, b, pair).possible(in_a == Interior::unknown, in_b == Interior::unknown);
  std::int32_t of_a = -1, of_b = -1;
  if (in_a == Interior::enclosed) of_b = held_vertex(fine_a, fine_b, pair.b_to_a(), unknown);
  if (in_b == Interior::enclosed && of_b < 0) of_a = held_vertex(fine_b, fine_a, pair.a_to_b(), unknown);
  if (of_a >= 0 || of_b >= 0) {
    const Eigen::Vector3d point = of_a >= 0 ? pair.a(fine_a.vertex(of_a)) : pair.b(fine_b.vertex(of_b));
    result = {0, 0, point, point};
    if (of_a >= 0) result.triangle_a = triangle_of(a.fine, of_a);
    if (of_b >= 0) result.triangle_b = triangle_of(b.fine, of_b);
  } else if (unknown) {
    result.lower = 0;
  }
}

/// Moves the nearest points of cores to the surfaces of the primitives; where these meet, to a point of both.
void move_to_surfaces(double radius_a, double radius_b, DistanceResult& result) {
  const Eigen::Vector3d way = result.point_b - result.point_a;
  const double length = way.norm();
  if (result.upper == 0) {
    result.point_a = result.point_b = result.point_a + radius_a / (radius_a + radius_b) * way;
  } else if (length > 0) {
    result.point_a += radius_a / length * way;
    result.point_b -= radius_b / length * way;
  }
}

/// distance() of simple shapes whose positions are off by `moved` at most. Points remain unset where the distance is
/// not below the limit.
DistanceResult simple_distance(const SimpleShape& a, const Motion& motion_a, const SimpleShape& b,
                               const Motion& motion_b, double moved, const DistanceOptions& options,
                               std::int64_t& steps) {
  const RestingPair pair(a.frame, motion_a, b.frame, motion_b);
  const double radius_a = pair.scale_a * a.convex_radius, radius_b = pair.scale_b * b.convex_radius;
  const bool rounded = radius_a + radius_b > 0;
  const double slack = core_error_in_world(a, b, pair) + moved;
  const double beyond = rounded ? error_in_world(a, b, pair) + moved : slack;
  const double balls = ball_bound(a, b, pair, beyond + pair.error);
  if (balls >= options.limit) return {.lower = balls};
  FineLease lease_a, lease_b;
  if (!a.has_fine() || !b.has_fine() || !lease_a.take(a) || !lease_b.take(b)) {
    const CageDistanceOptions finest{.enough = options.limit + moved, .tolerance = options.tolerance, .finest_cage = 0};
    return {.lower = std::max(0.0, cage_bound(a, b, pair, finest, steps) - moved)};
  }
  const SurfaceDistance found = surface_distance({a.fine, pair.scale_a}, {b.fine, pair.scale_b}, pair,
                                                 {.limit = options.limit + beyond,
                                                  // A fraction of the cores' distance may be all of the bodies'.
                                                  .tolerance = rounded ? 0 : options.tolerance,
                                                  .vertex_error = slack,
                                                  .hint = options.hint,
                                                  .steps = &steps});
  DistanceResult result{std::max(0.0, found.lower - beyond),
                        found.crossing ? 0 : found.upper + slack,
                        found.point_a,
                        found.point_b,
                        found.triangle_a,
                        found.triangle_b,
                        found.exhausted};
  if (rounded) {
    const double radii = a.least_radius(pair.scale_a) + b.least_radius(pair.scale_b);
    result.upper = std::max(0.0, result.upper - radii);
    if (!found.crossing) move_to_surfaces(radius_a, radius_b, result);
  }
  if (found.lower > pair.located() + slack) {
    look_inside(a, b, pair, result);
  } else {
    result.lower = 0;  // too near for a proof that nothing is inside
  }
  result.point_a += pair.origin;
  result.point_b += pair.origin;
  return result;
}

Motion at_start(const Motion& motion) { return Motion::resting(motion.start, motion.scale); }

}  // namespace

double cage_distance_bound(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                           const CageDistanceOptions& options) noexcept {
  const Motion at_a = at_start(motion_a), at_b = at_start(motion_b);
  if (!is_usable(at_a) || !is_usable(at_b) || !(options.enough > 0) || !(options.tolerance >= 0) ||
      options.most_steps < 0) {
    return 0;
  }
  double bound = options.enough;
  std::int64_t steps = options.most_steps;
  for_each_part_pair(a, at_a, b, at_b, options.enough, [&](const MovingPart& part_a, const MovingPart& part_b) {
    const double moved = part_a.slack + part_b.slack;
    CageDistanceOptions asked = options;
    asked.enough = bound + moved;
    const RestingPair pair(part_a.shape->frame, part_a.motion, part_b.shape->frame, part_b.motion);
    bound = std::min(bound, std::max(0.0, cage_bound(*part_a.shape, *part_b.shape, pair, asked, steps) - moved));
    return bound > 0;
  });
  return bound;
}

DistanceResult distance(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                        const DistanceOptions& options) noexcept {
  const Motion at_a = at_start(motion_a), at_b = at_start(motion_b);
  if (!is_usable(at_a) || !is_usable(at_b) || !(options.limit > 0) || !(options.tolerance >= 0) ||
      options.most_steps < 0) {
    return {};
  }
  DistanceResult nearest;
  nearest.lower = options.limit;
  std::int64_t steps = options.most_steps;
  const auto ask = [&](const MovingPart& part_a, const MovingPart& part_b) {
    DistanceOptions asked = options;
    asked.limit = std::min(options.limit, nearest.upper);
    // An index out of range for all parts but one.
    asked.hint = options.hint.a < 0 || options.hint.b < 0
                     ? TrianglePair{-1, -1}
                     : TrianglePair{options.hint.a - part_a.first_triangle, options.hint.b - part_b.first_triangle};
    DistanceResult found = simple_distance(*part_a.shape, part_a.motion, *part_b.shape, part_b.motion,
                                           part_a.slack + part_b.slack, asked, steps);
    if (found.triangle_a >= 0) found.triangle_a += part_a.first_triangle;
    if (found.triangle_b >= 0) found.triangle_b += part_b.first_triangle;
    const double lower = std::min(nearest.lower, found.lower);
    const bool exhausted = nearest.exhausted || found.exhausted;
    if (found.upper < nearest.upper) nearest = found;
    nearest.lower = lower;
    nearest.exhausted = exhausted && nearest.upper > 0;
    return nearest.upper > 0;
  };
  // Most of many parts are too far away: the distance of two near ones tells which.
  constexpr std::int64_t many = 32;
  if (part_count(a) > many || part_count(b) > many) {
    const MovingPart near_a = near_part(a, at_a, world_box(b, at_b));
    if (!ask(near_a, near_part(b, at_b, world_box(*near_a.shape, near_a.motion)))) return nearest;
  }
  for_each_part_pair(a, at_a, b, at_b, std::min(options.limit, nearest.upper), ask);
  if (nearest.lower >= options.limit) return {.lower = options.limit};
  return nearest;
}

}  // namespace encage
