// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/nearest_point.h"
#include "broadphase/query/near_parts.h"
#include "broadphase/query/point_side.h"
#include "broadphase/query/rounded.h"
#include "broadphase/separation/containment.h"

#include <encage/fine_lease.h>
#include <encage/queries.h>

#include <algorithm>
#include <cmath>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

bool is_usable(const Vector& point) { return point.allFinite() && point.cwiseAbs().maxCoeff() <= largest_length; }

/// A point and one part of a body.
struct PartPoint {
  ClosestPoint closest;
  PointSide side = PointSide::unknown;
};

/// The finest cage bounds the distance from below. Cages of compounds and simple shapes alike hold the body.
ClosestPoint beside_cage(const PosedPart& part, const Vector& p, double slack) {
  ClosestPoint result;
  if (part.shape().cages.empty()) return result;
  const Surface& cage = part.shape().cages.front();
  SurfacePoint nearest;
  if (locate(cage, p) != Side::outside || !nearest_point(cage, p, infinity, nearest)) return result;
  result.lower = std::max(0.0, part.shortest(nearest.lower) - slack);
  return result;
}

void set_feature(const PosedPart& part, const SurfacePoint& nearest, ClosestPoint& result) {
  result.triangle = nearest.triangle + part.first_triangle();
  result.feature = nearest.kind == SurfacePoint::Kind::face   ? SurfaceFeature::face
                   : nearest.kind == SurfacePoint::Kind::edge ? SurfaceFeature::edge
                                                              : SurfaceFeature::vertex;
  result.corner = nearest.kind == SurfacePoint::Kind::face ? 0 : nearest.corner;
}

ClosestPoint on_fine(const PosedPart& part, const Surface& fine, const Vector& point, const Vector& p, double limit,
                     double slack) {
  ClosestPoint result;
  SurfacePoint nearest;
  if (!nearest_point(fine, p, part.farthest_local(limit), nearest)) {
    result.lower = std::max(0.0, limit - slack);
    return result;
  }
  result.point = part.world(nearest.point);
  result.upper = (point - result.point).norm() * (1 + 4 * eps) + slack;
  result.lower = std::max(0.0, part.shortest(nearest.lower) - slack);
  set_feature(part, nearest, result);
  return result;
}

PartPoint on_rounded(const PosedPart& part, const Vector& point, double limit) {
  const RoundedPoint found = nearest_on_rounded(part, point);
  PartPoint result;
  result.side = found.side();
  result.closest.lower = std::max({0.0, found.lower, -found.upper});
  if (result.closest.lower >= limit) {
    result.closest.lower = limit;
    return result;
  }
  result.closest.upper = std::max(std::abs(found.lower), std::abs(found.upper));
  result.closest.point = found.point;
  set_feature(part, found.core, result.closest);
  return result;
}

PartPoint ask(const PosedPart& part, const Vector& point, double limit, bool with_side) {
  if (part.shape().convex_radius > 0) return on_rounded(part, point, limit);
  FineLease lease;
  const Surface* fine = fine_surface(part.shape(), lease);
  const Vector p = part.local(point);
  const double slack = part.rounding(point.norm()) + part.fine_error();
  PartPoint result;
  result.closest = fine != nullptr ? on_fine(part, *fine, point, p, limit, slack) : beside_cage(part, p, slack);
  if (with_side) result.side = side_of(part, fine, p, slack, result.closest.lower > 0);
  return result;
}

/// Distance to a box, less what rounding may have added.
double to_box(const Eigen::AlignedBox3d& box, const Vector& p) { return (1 - 16 * eps) * box.exteriorDistance(p); }

ClosestPoint closest_of(const CompoundShape& compound, const Motion& motion, const Vector& point, double limit) {
  const PosedParts parts(compound, motion);
  const Vector p = parts.local(point);
  const double slack = parts.rounding(point.norm());
  ClosestPoint best;
  best.lower = limit;
  parts.visit_in_order(
      [&](const Eigen::AlignedBox3d& box) {
        const double apart = parts.shortest(std::max(0.0, to_box(box, p) - slack));
        return apart <= std::min(limit, best.upper);
      },
      [&](const MovingPart& moving) {
        const ClosestPoint found =
            ask(PosedPart(moving), point, std::min(limit, best.upper * (1 + 4 * eps)), false).closest;
        const double lower = std::min(best.lower, found.lower);
        if (found.upper < best.upper || (found.upper == best.upper && found.triangle < best.triangle)) best = found;
        best.lower = lower;
        return true;
      },
      [&](const Eigen::AlignedBox3d& first, const Eigen::AlignedBox3d& second) {
        return second.squaredExteriorDistance(p) < first.squaredExteriorDistance(p);
      });
  best.lower = std::min(best.lower, best.upper);
  return best;
}

/// Bounds of the distance with its sign.
SignedDistance with_sign(const ClosestPoint& closest, PointSide side) {
  SignedDistance result;
  result.closest = closest;
  result.side = side;
  switch (side) {
    case PointSide::outside:
      result.lower = closest.lower;
      result.upper = closest.upper;
      break;
    case PointSide::inside:
      result.lower = -closest.upper;
      result.upper = -closest.lower;
      break;
    case PointSide::unknown:
      result.lower = -closest.upper;
      result.upper = closest.upper;
      break;
  }
  return result;
}

SignedDistance signed_of(const CompoundShape& compound, const Motion& motion, const Vector& point, double limit) {
  SignedDistance result;
  result.closest = closest_of(compound, motion, point, limit);
  const PosedParts parts(compound, motion);
  const Vector p = parts.local(point);
  const double slack = parts.rounding(point.norm());
  bool inside = false, unknown = false;
  double lower = result.closest.lower, upper = result.closest.upper;
  parts.visit([&](const Eigen::AlignedBox3d& box) { return to_box(box, p) <= slack; },
              [&](const MovingPart& moving) {
                const PartPoint found = ask(PosedPart(moving), point, limit, true);
                const SignedDistance own = with_sign(found.closest, found.side);
                inside = inside || found.side == PointSide::inside;
                unknown = unknown || found.side == PointSide::unknown;
                lower = std::min(lower, own.lower);
                upper = std::min(upper, own.upper);
                return true;
              });
  result.side = inside ? PointSide::inside : unknown ? PointSide::unknown : PointSide::outside;
  result.lower = lower;
  result.upper = upper;
  return result;
}

/// Answers each point by of_part(part, point) or, of a compound, by of_compound(motion, point). A point that cannot be
/// asked about gets the answer that a new result holds.
template <class Answer, class OfPart, class OfCompound>
void answer_each(const Shape& shape, const Motion& motion, std::span<const Vector> points, std::span<Answer> results,
                 double limit, OfPart&& of_part, OfCompound&& of_compound) {
  const std::size_t count = std::min(points.size(), results.size());
  const Motion at = start_of(motion);
  const bool usable = is_usable(at) && limit > 0;
  const auto each = [&](const auto& answer) {
    for (std::size_t i = 0; i < count; ++i) results[i] = usable && is_usable(points[i]) ? answer(points[i]) : Answer{};
  };
  if (shape.is_compound()) {
    each([&](const Vector& p) { return of_compound(at, p); });
    return;
  }
  FineLease lease;
  fine_surface(shape.simple(), lease);
  const PosedPart part(MovingPart{&shape.simple(), at});
  each([&](const Vector& p) { return of_part(part, p); });
}

}  // namespace

void closest_points(const Shape& shape, const Motion& motion, std::span<const Vector> points,
                    std::span<ClosestPoint> results, const ClosestPointOptions& options) noexcept {
  answer_each(
      shape, motion, points, results, options.limit,
      [&](const PosedPart& part, const Vector& p) { return ask(part, p, options.limit, false).closest; },
      [&](const Motion& at, const Vector& p) { return closest_of(shape.compound(), at, p, options.limit); });
}

ClosestPoint closest_point(const Shape& shape, const Motion& motion, const Vector& point,
                           const ClosestPointOptions& options) noexcept {
  ClosestPoint result;
  closest_points(shape, motion, {&point, 1}, {&result, 1}, options);
  return result;
}

void signed_distances(const Shape& shape, const Motion& motion, std::span<const Vector> points,
                      std::span<SignedDistance> results, const ClosestPointOptions& options) noexcept {
  answer_each(
      shape, motion, points, results, options.limit,
      [&](const PosedPart& part, const Vector& p) {
        const PartPoint found = ask(part, p, options.limit, true);
        return with_sign(found.closest, found.side);
      },
      [&](const Motion& at, const Vector& p) { return signed_of(shape.compound(), at, p, options.limit); });
}

SignedDistance signed_distance(const Shape& shape, const Motion& motion, const Vector& point,
                               const ClosestPointOptions& options) noexcept {
  SignedDistance result;
  signed_distances(shape, motion, {&point, 1}, {&result, 1}, options);
  return result;
}

}  // namespace encage
