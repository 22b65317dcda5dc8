// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/nearest_point.h"
#include "broadphase/query/near_parts.h"
#include "broadphase/query/point_side.h"
#include "broadphase/query/ray_search.h"
#include "broadphase/query/rounded.h"
#include "broadphase/separation/containment.h"

#include <encage/fine_lease.h>
#include <encage/queries.h>

#include <algorithm>
#include <optional>

namespace encage {
namespace {

/// True if the point is proven to lie farther than `reach` from the box of a surface.
bool beyond_box(const Surface& surface, const Eigen::Vector3d& p, double reach) {
  for (int axis = 0; axis < 3; ++axis) {
    if (p[axis] < static_cast<double>(surface.lower[axis]) - reach ||
        p[axis] > static_cast<double>(surface.upper[axis]) + reach) {
      return true;
    }
  }
  return false;
}

/// locate(), faster.
Side side_in(const Surface& surface, const Eigen::Vector3d& p) {
  if (beyond_box(surface, p, 0)) return Side::outside;
  for (const WindingRay& ray : rays) {
    if (const std::optional<int> number = winding_number(surface, ray, p)) {
      return *number != 0 ? Side::inside : Side::outside;
    }
  }
  return Side::unknown;
}

bool near_surface(const Surface& surface, const Eigen::Vector3d& p, double reach) {
  SurfacePoint nearest;
  return nearest_point(surface, p, reach, nearest);
}

}  // namespace

PointSide side_of(const PosedPart& part, const Surface* fine, const Eigen::Vector3d& p, double slack,
                  bool clear) noexcept {
  const double reach = part.farthest_local(slack);
  const SimpleShape& shape = part.shape();
  if (fine == nullptr) {
    if (shape.cages.empty()) return PointSide::unknown;
    const Surface& cage = shape.cages.front();
    if (beyond_box(cage, p, reach)) return PointSide::outside;
    const bool outside = locate(cage, p) == Side::outside && !near_surface(cage, p, reach);
    return outside ? PointSide::outside : PointSide::unknown;
  }
  if (beyond_box(*fine, p, reach)) return PointSide::outside;
  const Interior kind = interior(shape);
  if (kind == Interior::unknown) return PointSide::unknown;
  if (!clear && near_surface(*fine, p, reach)) return PointSide::unknown;
  if (kind == Interior::none) return PointSide::outside;
  switch (side_in(*fine, p)) {
    case Side::outside: return PointSide::outside;
    case Side::inside: return PointSide::inside;
    case Side::unknown: break;
  }
  return PointSide::unknown;
}

PointSide side_of(const Shape& shape, const Motion& motion, const Eigen::Vector3d& point) noexcept {
  const auto of_part = [&](const MovingPart& moving) {
    const PosedPart part(moving);
    if (part.shape().convex_radius > 0) return nearest_on_rounded(part, point).side();
    FineLease lease;
    const Surface* fine = fine_surface(part.shape(), lease);
    return side_of(part, fine, part.local(point), part.rounding(point.norm()) + part.fine_error(), false);
  };
  if (!shape.is_compound()) return of_part(MovingPart{&shape.simple(), motion});
  const PosedParts parts(shape.compound(), motion);
  const Eigen::Vector3d p = parts.local(point);
  const double slack = parts.rounding(point.norm());
  PointSide side = PointSide::outside;
  parts.visit([&](const Eigen::AlignedBox3d& box) { return (1 - 16 * eps) * box.exteriorDistance(p) <= slack; },
              [&](const MovingPart& part) {
                const PointSide own = of_part(part);
                if (own != PointSide::outside) side = own;
                return side != PointSide::inside;
              });
  return side;
}

void contains(const Shape& shape, const Motion& motion, std::span<const Eigen::Vector3d> points,
              std::span<PointSide> sides) noexcept {
  const std::size_t count = std::min(points.size(), sides.size());
  const Motion at = start_of(motion);
  const bool usable = is_usable(at);
  FineLease lease;
  if (!shape.is_compound()) fine_surface(shape.simple(), lease);
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d& p = points[i];
    sides[i] = usable && p.allFinite() && p.cwiseAbs().maxCoeff() <= largest_length ? side_of(shape, at, p)
                                                                                    : PointSide::unknown;
  }
}

PointSide contains(const Shape& shape, const Motion& motion, const Eigen::Vector3d& point) noexcept {
  PointSide side = PointSide::unknown;
  contains(shape, motion, {&point, 1}, {&side, 1});
  return side;
}

}  // namespace encage
