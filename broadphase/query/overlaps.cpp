// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/box_corners.h"
#include "broadphase/query/convex_distance.h"
#include "broadphase/query/near_parts.h"
#include "broadphase/query/point_side.h"
#include "broadphase/separation/containment.h"
#include "src/tree/visit.h"

#include <encage/fine_lease.h>
#include <encage/queries.h>
#include <encage/separated.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// The hull of some points in the world, compared with one surface. Triangles are mapped to the world, not
/// the hull to the surface: a triangle has three corners, a hull any number.
class HullSearch {
 public:
  HullSearch(const PosedPart& part, const Surface& surface, std::span<const Vector> points, double distance)
      : part_(part), surface_(surface), points_(points), distance_(distance) {
    // The box of the hull in grid coordinates, and the ball around it.
    const TreeGrid& grid = surface.tree.grid;
    const double step = static_cast<double>(grid.step);
    const double reach = part.farthest_local(distance) / step;
    lower_.fill(infinity);
    upper_.fill(-infinity);
    for (const Vector& p : points) {
      const Vector x = part.local(p);
      for (int axis = 0; axis < 3; ++axis) {
        const double at = grid.coordinate(axis, x[axis]);
        lower_[axis] = std::min(lower_[axis], at);
        upper_[axis] = std::max(upper_[axis], at);
      }
    }
    const double wider = reach + 2 * grid.rounding() + 1e-3;
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
      middle_[axis] = 0.5 * (lower_[axis] + upper_[axis]);
      squared += (upper_[axis] - lower_[axis]) * (upper_[axis] - lower_[axis]) / 4;
      lower_[axis] -= wider;
      upper_[axis] += wider;
    }
    radius_ = std::sqrt(squared) + wider;
  }

  /// False only if all triangles are proven farther apart from the hull than the distance.
  bool any_near() {
    return !visit_nodes(surface_.tree, [&](const MeshNode& node, auto&& descend) {
      for (int lane = 0; lane < MeshNode::width; ++lane) {
        const int count = node.count(lane);
        if (count == MeshNode::unused) break;
        if (apart(node, lane)) continue;
        if (count == MeshNode::inner) {
          descend(node.child(lane));
          continue;
        }
        for (std::int32_t i = node.child(lane); i < node.child(lane) + count; ++i) {
          if (!triangle_apart(surface_.tree.leaves[static_cast<std::size_t>(i)])) return false;
        }
      }
      return true;
    });
  }

 private:
  bool apart(const MeshNode& node, int lane) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (node.lower[axis][lane] > upper_[axis] || node.upper[axis][lane] < lower_[axis]) return true;
    }
    // Along the slab's normal the hull is within its ball.
    double height = 0, squared = 0, size = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double n = node.normal[axis][lane];
      height += n * middle_[axis];
      squared += n * n;
      size += std::abs(n * middle_[axis]);
    }
    const double reach = std::sqrt(squared) * radius_ * (1 + 8 * eps) + 8 * eps * size;
    return squared > 0 && (height - reach > static_cast<double>(node.slab_upper[lane]) * MeshNode::slab_unit ||
                           height + reach < static_cast<double>(node.slab_lower[lane]) * MeshNode::slab_unit);
  }

  bool triangle_apart(const LeafTriangle& triangle) {
    TriangleD corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = part_.world(surface_.vertex(triangle.vertices[k]));
    return hull_apart(points_, corners, distance_, axis_);
  }

  const PosedPart& part_;
  const Surface& surface_;
  std::span<const Vector> points_;
  double distance_;
  std::array<double, 3> lower_, upper_, middle_{};
  double radius_ = 0;
  Vector axis_ = Vector::Zero();
};

/// True unless the hull, widened by `radius`, is proven to have no point in common with a part of a body.
bool overlaps_part(const PosedPart& part, std::span<const Vector> points, double radius, double norm) {
  FineLease lease;
  const Surface* fine = fine_surface(part.shape(), lease);
  if (fine == nullptr && part.shape().cages.empty()) return true;
  const Surface& surface = fine != nullptr ? *fine : part.shape().cages.front();
  const double distance = (radius + part.rounding(norm + radius) + part.fine_error()) * (1 + 8 * eps);
  if (HullSearch(part, surface, points, distance).any_near()) return true;
  if (fine == nullptr) return locate(surface, part.local(points.front())) != Side::outside;
  switch (interior(part.shape())) {
    case Interior::none: return false;
    case Interior::enclosed: return locate(*fine, part.local(points.front())) != Side::outside;
    case Interior::unknown: break;
  }
  // The hull may lie in the interior, which is somewhere in the box of the surface.
  const double reach = part.farthest_local(distance);
  Eigen::AlignedBox3d box;
  for (const Vector& p : points) box.extend(part.local(p));
  for (int axis = 0; axis < 3; ++axis) {
    if (box.min()[axis] - reach > static_cast<double>(fine->upper[axis]) ||
        box.max()[axis] + reach < static_cast<double>(fine->lower[axis])) {
      return false;
    }
  }
  return true;
}

bool overlaps_hull(const Shape& shape, const Motion& motion, std::span<const Vector> points, double radius) {
  if (points.empty()) return false;
  const Motion at = start_of(motion);
  double norm = 0;
  for (const Vector& p : points) {
    if (!p.allFinite() || !(p.cwiseAbs().maxCoeff() <= largest_length)) return true;
    norm = std::max(norm, p.norm());
  }
  if (!is_usable(at) || !(radius >= 0 && radius <= largest_length)) return true;
  if (!shape.is_compound()) return overlaps_part(PosedPart(MovingPart{&shape.simple(), at}), points, radius, norm);
  const PosedParts parts(shape.compound(), at);
  Eigen::AlignedBox3d hull;
  for (const Vector& p : points) hull.extend(parts.local(p));
  const double reach = (1 + 4 * rigid_tolerance) * radius / parts.scale() + parts.rounding(norm + radius);
  return !parts.visit(
      [&](const Eigen::AlignedBox3d& box) { return (1 - 16 * eps) * box.exteriorDistance(hull) <= reach; },
      [&](const MovingPart& part) { return !overlaps_part(PosedPart(part), points, radius, norm); });
}

}  // namespace

bool overlaps(const Shape& shape, const Motion& motion, std::span<const Vector> hull, double radius) noexcept {
  return overlaps_hull(shape, motion, hull, radius);
}

bool overlaps(const Shape& shape, const Motion& motion, const Sphere& sphere) noexcept {
  return overlaps_hull(shape, motion, {&sphere.centre, 1}, sphere.radius);
}

bool overlaps(const Shape& shape, const Motion& motion, const Capsule& capsule) noexcept {
  const std::array<Vector, 2> ends = {capsule.a, capsule.b};
  return overlaps_hull(shape, motion, ends, capsule.radius);
}

bool overlaps(const Shape& shape, const Motion& motion, const OrientedBox& box) noexcept {
  BoxCorners corners;
  double rounding = 0;
  return !corners_of(box, corners, rounding) || overlaps_hull(shape, motion, corners, rounding);
}

bool overlaps(const Shape& shape, const Motion& motion, const HalfSpace& half_space) noexcept {
  return !separated(shape, start_of(motion), half_space).separated;
}

}  // namespace encage
