// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/box_corners.h"
#include "broadphase/query/convex_distance.h"
#include "broadphase/query/near_parts.h"
#include "broadphase/separation/containment.h"
#include "src/tree/visit.h"

#include <encage/casts.h>
#include <encage/fine_lease.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;

/// The hull of some points in the world, widened by a radius, on a straight way.
struct MovingHull {
  std::span<const Vector> points;
  double radius;
  Vector way;
  Vector middle = Vector::Zero();  ///< a point of the hull
  double size = 0;                 ///< bounds the norms of points on the way, with the radius
};

/// The beginning of a contact of a hull and a triangle.
struct Touch {
  double time = 0;
  Vector normal = Vector::Zero();
  bool crosses = false;  ///< at the start, by more than the rounding
};

/// Distances in the world that decide about a touch.
struct TouchBounds {
  double distance;   ///< beyond it there is none: radius, rounding and fine_error
  double tolerance;  ///< hulls that are nearer than this beyond it touch
  double radius;
};

/// Hull and triangle are not proven to be apart at the start. They touch if an axis shows that they go no deeper than
/// rounding. Such axes are the triangle's normal, and those that part them when the hull is moved away from the
/// triangle's middle: with convex bodies that touch, these part them where they are, too, unless it is moved too far.
Touch touch_at_start(const MovingHull& hull, const TriangleD& triangle, const HullGap& gap, const TouchBounds& bounds) {
  Touch touch;
  double best = -infinity;
  const auto consider = [&](const Vector& axis) {
    const double length = axis.norm();
    if (!(length * length > smallest_square)) return;
    double low = infinity, high = -infinity;
    for (const Vector& p : hull.points) low = std::min(low, axis.dot(p));
    for (const Vector& p : triangle) high = std::max(high, axis.dot(p));
    if (!((low - high) / length > best)) return;
    best = (low - high) / length;
    touch.normal = axis / length;
  };
  consider(gap.axis);
  const Vector n = unit_normal(triangle);
  consider(n);
  consider(-n);
  const double least = 2 * bounds.radius - bounds.distance;
  const Vector away = hull.middle - (triangle[0] + triangle[1] + triangle[2]) / 3;
  for (double share = 1; share > 0.01 && !(best >= least); share /= 4) {
    consider(nearest_to_hull(hull.points, share * away, triangle).axis);
  }
  touch.crosses = !(best >= least);
  return touch;
}

/// True if the axis proves that the hull does not touch the triangle up to `last`: at both ends of that way it proves a
/// larger distance.
bool passes_along(const Vector& axis, const MovingHull& hull, const TriangleD& triangle, double distance, double last) {
  double low = infinity, high = -infinity;
  for (const Vector& p : hull.points) low = std::min(low, axis.dot(p));
  for (const Vector& p : triangle) high = std::max(high, axis.dot(p));
  const double length = axis.norm(), room = low - high - length * distance;
  return length * length > smallest_square && room > 0 && room + last * axis.dot(hull.way) > 0;
}

/// Projections of hull and triangle on an axis that leads from the triangle to the hull.
struct AxisRoom {
  double room = 0;  ///< beyond the distance, at the start, times the axis' length
  double rate = 0;  ///< how fast it grows
};

AxisRoom room_along(const Vector& axis, const MovingHull& hull, const TriangleD& triangle, double distance) {
  double low = infinity, high = -infinity;
  for (const Vector& p : hull.points) low = std::min(low, axis.dot(p));
  for (const Vector& p : triangle) high = std::max(high, axis.dot(p));
  return {low - high - axis.norm() * distance, axis.dot(hull.way)};
}

/// Next to a touch an axis between two points is rounding, which tilts it along edges and faces that lie side by side.
/// Finds one at right angles to one or two edges of the triangle or lines between points of the hull, of those that are
/// nearly so, that proves the hull to be apart for longer than up to `time`; 0 if there is none.
Vector straightened(const Vector& axis, const MovingHull& hull, const TriangleD& triangle, double distance,
                    double time) {
  constexpr double nearly = 1e-3;  // the cosine of almost a right angle
  constexpr std::size_t few = 8;   // points of a hull whose lines are tried
  std::array<Vector, 3 + few*(few - 1) / 2> edges;
  std::size_t count = 0;
  const auto collect = [&](const Vector& edge) {
    const double squared = edge.squaredNorm(), along = axis.dot(edge);
    if (squared > smallest_square && along * along < nearly * nearly * squared * axis.squaredNorm()) {
      edges[count++] = edge;
    }
  };
  for (std::size_t k = 0; k < 3; ++k) collect(triangle[(k + 1) % 3] - triangle[k]);
  for (std::size_t i = 0; i < std::min(hull.points.size(), few); ++i) {
    for (std::size_t j = 0; j < i; ++j) collect(hull.points[i] - hull.points[j]);
  }
  Vector best = Vector::Zero();
  double latest = time;
  const auto consider = [&](const Vector& straight) {
    const AxisRoom of = room_along(straight, hull, triangle, distance);
    if (!(of.room + time * of.rate > 0)) return;
    const double until = of.rate < 0 ? of.room / -of.rate : infinity;
    if (!(until > latest)) return;
    latest = until;
    best = straight;
  };
  for (std::size_t i = 0; i < count; ++i) {
    consider(axis - axis.dot(edges[i]) / edges[i].squaredNorm() * edges[i]);
    for (std::size_t j = 0; j < i; ++j) {
      const Vector across = edges[i].cross(edges[j]);
      // The product of lines that are nearly parallel is rounding itself.
      if (across.squaredNorm() > nearly * nearly * edges[i].squaredNorm() * edges[j].squaredNorm()) {
        consider(axis.dot(across) > 0 ? across : Vector(-across));
      }
    }
  }
  return best;
}

/// Finds when a hull begins to touch a triangle; no value if it is proven not to up to `last`. `axis` may show that;
/// one that does is left there for a triangle nearby. The distance is convex in time, so that the steps that an axis
/// proves free lead to the first touch as Newton's method leads to a root, and never beyond it (compare van den Bergen
/// 2004, "Ray casting against general convex objects").
std::optional<Touch> first_touch(const MovingHull& hull, const TriangleD& triangle, const TouchBounds& bounds,
                                 double last, Vector& axis) {
  constexpr int most_steps = 64;
  if (passes_along(axis, hull, triangle, bounds.distance, last)) return std::nullopt;
  // If the hull comes nearer all the time, an axis that parts them at the end proves the whole way.
  const HullGap end = hull_gap(hull.points, last * hull.way, -last * hull.way, triangle, bounds.distance);
  if (end.passes) {
    axis = end.axis;
    return std::nullopt;
  }
  Touch touch;
  for (int step = 0; step < most_steps; ++step) {
    const HullGap gap =
        hull_gap(hull.points, touch.time * hull.way, (last - touch.time) * hull.way, triangle, bounds.distance);
    if (gap.passes) return std::nullopt;
    if (step > 0 && gap.upper <= bounds.distance + bounds.tolerance) return touch;
    Vector along = gap.axis;
    AxisRoom of{gap.low - gap.high - gap.length * bounds.distance, gap.axis.dot(hull.way)};
    const bool proves = of.room + touch.time * of.rate > 0;
    if (!proves && step == 0) return touch_at_start(hull, triangle, gap, bounds);
    // A good axis proves a fair share of the way that is left at least. Otherwise the last one may, once straight.
    const double left = (gap.upper - bounds.distance) / hull.way.norm();
    bool found = proves;
    if (!proves || (step > 0 && of.rate < 0 && of.room / -of.rate < touch.time + 0.1 * left)) {
      for (const Vector& tilted : {gap.axis, touch.normal}) {
        const Vector straight = straightened(tilted, hull, triangle, bounds.distance, touch.time);
        const AxisRoom other = room_along(straight, hull, triangle, bounds.distance);
        if (straight.isZero(0) || (found && other.rate < 0 && !(other.room / -other.rate > of.room / -of.rate)))
          continue;
        found = true;
        along = straight;
        of = other;
      }
    }
    if (!found) return touch;
    // The axis proves the whole way up to here.
    const double next = of.room / -of.rate;
    if (of.rate >= 0 || next > last) return std::nullopt;
    touch.normal = along.normalized();
    if (!(next > touch.time)) return touch;
    touch.time = next;
  }
  return touch;
}

/// The earliest touch that a cast has found so far.
struct CastState {
  double last = 1;  ///< no later touch is of interest
  std::int32_t triangle = -1;
  TriangleD corners{};
  Vector normal = Vector::Zero();
  double tolerance = 0;
  bool overlapping = false;
};

/// A moving hull and one surface.
class CastSearch {
 public:
  CastSearch(const PosedPart& part, const Surface& surface, const MovingHull& hull, const TouchBounds& bounds)
      : part_(part), surface_(surface), hull_(hull), bounds_(bounds) {
    // The box of the hull at the start and the ball around it, in grid coordinates.
    const TreeGrid& grid = surface.tree.grid;
    const double step = static_cast<double>(grid.step);
    lower_.fill(infinity);
    upper_.fill(-infinity);
    for (const Vector& p : hull.points) {
      const Vector x = part.local(p);
      for (int axis = 0; axis < 3; ++axis) {
        const double at = grid.coordinate(axis, x[axis]);
        lower_[axis] = std::min(lower_[axis], at);
        upper_[axis] = std::max(upper_[axis], at);
      }
    }
    const double wider = part.farthest_local(bounds.distance) / step + 2 * grid.rounding() + 2e-3;
    const Vector way = part.local_direction(hull.way) / step;
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
      middle_[axis] = 0.5 * (lower_[axis] + upper_[axis]);
      squared += (upper_[axis] - lower_[axis]) * (upper_[axis] - lower_[axis]) / 4;
      lower_[axis] -= wider;
      upper_[axis] += wider;
      half_[axis] = 0.5 * (upper_[axis] - lower_[axis]);
      rate_[axis] = way[axis];
    }
    radius_ = std::sqrt(squared) + wider;
    wider_ = wider;
    if (hull.points.size() > offsets_.size()) return;
    for (const Vector& p : hull.points) {
      const Vector x = part.local(p);
      for (int axis = 0; axis < 3; ++axis) offsets_[few_][axis] = grid.coordinate(axis, x[axis]) - middle_[axis];
      ++few_;
    }
  }

  /// Looks for a touch before `state.last`, or as early in a triangle with a lower number. Nodes that the hull comes to
  /// first are opened first.
  void search(CastState& state) {
    struct Entry {
      double enter;
      const MeshNode* parent;
      std::size_t lane;
    };
    std::array<Entry, traversal_stack_size> stack;
    std::size_t size = 0;
    stack[size++] = {0, nullptr, 0};
    while (size > 0) {
      const Entry entry = stack[--size];
      if (entry.enter > state.last || (entry.parent != nullptr && passes(*entry.parent, entry.lane, state))) continue;
      const std::uint32_t link = entry.parent != nullptr ? entry.parent->link[entry.lane] : 0;
      const int count = MeshNode::count_of(link);
      const std::int32_t child = MeshNode::child_of(link);
      if (count != MeshNode::inner) {
        for (std::int32_t i = child; i < child + count; ++i) {
          consider(surface_.tree.leaves[static_cast<std::size_t>(i)], state);
          if (state.overlapping) return;
        }
        continue;
      }
      const MeshNode& node = surface_.tree.nodes[static_cast<std::size_t>(child)];
      std::array<double, MeshNode::width> enter, leave;
      times_of_boxes(node, enter, leave);
      const std::size_t bottom = size;
      for (std::size_t lane = 0; lane < MeshNode::width; ++lane) {
        if (node.link[lane] >= MeshNode::unused_link) break;
        if (!(enter[lane] <= leave[lane] && enter[lane] <= state.last)) continue;
        enter[lane] = later(node, lane, enter[lane]);
        if (enter[lane] > state.last) continue;
        std::size_t place = size++;
        for (; place > bottom && stack[place - 1].enter < enter[lane]; --place) stack[place] = stack[place - 1];
        stack[place] = {enter[lane], &node, lane};
      }
    }
  }

 private:
  using Axis = std::array<double, 3>;
  static constexpr double no_way = 1e-9;  // grid steps, below what the box is widened by

  /// Computes between which times, from 0 on, the hull may touch what lies in the boxes and slabs. Their rounding is
  /// below that of the hull's coordinates, by which its box is widened.
  void times_of_boxes(const MeshNode& node, std::array<double, MeshNode::width>& enter,
                      std::array<double, MeshNode::width>& leave) const {
    enter.fill(0);
    leave.fill(1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double low = lower_[axis], high = upper_[axis];
      const double rate = rate_[axis];
      if (std::abs(rate) < no_way) {
        for (std::size_t lane = 0; lane < MeshNode::width; ++lane) {
          if (node.lower[axis][lane] > high || node.upper[axis][lane] < low) enter[lane] = infinity;
        }
        continue;
      }
      const double inverse = 1 / rate;
      const auto* first = rate > 0 ? node.lower[axis] : node.upper[axis];
      const auto* second = rate > 0 ? node.upper[axis] : node.lower[axis];
      const double front = rate > 0 ? high : low, back = rate > 0 ? low : high;
      for (std::size_t lane = 0; lane < MeshNode::width; ++lane) {
        enter[lane] = std::max(enter[lane], (first[lane] - front) * inverse);
        leave[lane] = std::min(leave[lane], (second[lane] - back) * inverse);
      }
    }
    for (std::size_t lane = 0; lane < MeshNode::width; ++lane) {
      double height = 0, squared = 0, size = 0, reach = 0, rate = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double n = node.normal[axis][lane];
        height += n * middle_[axis];
        rate += n * rate_[axis];
        squared += n * n;
        size += std::abs(n) * (std::abs(middle_[axis]) + std::abs(rate_[axis]));
        reach += std::abs(n) * half_[axis];
      }
      if (!(squared > 0)) continue;
      reach = std::min(reach, std::sqrt(squared) * radius_) * (1 + 8 * eps) + 16 * eps * size;
      // Along the slab's normal, in which the hull is within its box and its ball.
      double low = node.slab_lower[lane] * static_cast<double>(MeshNode::slab_unit) - reach - height;
      double high = node.slab_upper[lane] * static_cast<double>(MeshNode::slab_unit) + reach - height;
      if (std::abs(rate) < 1e-6) {
        if (low > 1e-6 || high < -1e-6) enter[lane] = infinity;
        continue;
      }
      if (rate < 0) std::swap(low, high);
      enter[lane] = std::max(enter[lane], low / rate);
      leave[lane] = std::min(leave[lane], high / rate);
    }
  }

  /// Along an axis, the room between a box and the hull that is left at a time t: start + t * rate.
  struct Room {
    double start, rate;

    double at(double t) const { return start + t * rate; }
  };

  Room room_along(const MeshNode& node, std::size_t lane, const Axis& n) const {
    double high = 0, height = 0, rate = 0, squared = 0, within_box = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      high += n[axis] * (n[axis] > 0 ? node.upper[axis][lane] : node.lower[axis][lane]);
      height += n[axis] * middle_[axis];
      rate += n[axis] * rate_[axis];
      squared += n[axis] * n[axis];
      within_box += std::abs(n[axis]) * half_[axis];
    }
    // Sums that overflow prove nothing.
    if (!(squared > 0) || !std::isfinite(height) || !std::isfinite(rate)) return {-infinity, 0};
    const double length = std::sqrt(squared);
    double reach = std::min(within_box, length * radius_);
    if (few_ > 0) {
      double least = infinity;
      for (std::size_t i = 0; i < few_; ++i) {
        const Axis& p = offsets_[i];
        least = std::min(least, n[0] * p[0] + n[1] * p[1] + n[2] * p[2]);
      }
      reach = std::min(reach, length * wider_ - least);
    }
    return {height - reach * (1 + 8 * eps) - high, rate};
  }

  /// The direction from a box to the hull's middle at a time.
  Axis from_box(const MeshNode& node, std::size_t lane, double time) const {
    Axis toward;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double at = middle_[axis] + time * rate_[axis];
      toward[axis] = at - std::clamp<double>(at, node.lower[axis][lane], node.upper[axis][lane]);
    }
    return toward;
  }

  /// Returns a time up to which the hull does not touch what lies in a box, which it does not before `time`; infinite
  /// if it passes the box. Boxes in the order of these times lead to the first touch sooner.
  double later(const MeshNode& node, std::size_t lane, double time) const {
    for (int step = 0; step < 3; ++step) {
      const Room room = room_along(node, lane, from_box(node, lane, time));
      if (!(room.at(time) > 0)) break;
      if (room.rate >= 0) return infinity;
      time = std::max(time, room.start / -room.rate);
    }
    return time;
  }

  /// True if an axis proves that the hull does not touch what lies in a box up to `state.last`: the direction to the
  /// hull's middle then, or the normal of the touch that is known.
  bool passes(const MeshNode& node, std::size_t lane, const CastState& state) const {
    const auto clear = [&](const Axis& n) {
      const Room room = room_along(node, lane, n);
      return room.start > 0 && room.at(state.last) > 0;
    };
    return clear(from_box(node, lane, state.last)) || clear(normal_);
  }

  void consider(const LeafTriangle& triangle, CastState& state) {
    TriangleD corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = part_.world(surface_.vertex(triangle.vertices[k]));
    const std::optional<Touch> touch = first_touch(hull_, corners, bounds_, state.last, axis_);
    if (!touch) return;
    const std::int32_t number = triangle.triangle + part_.first_triangle();
    if (touch->crosses) state.overlapping = true;
    if (state.triangle >= 0 && touch->time >= state.last && state.triangle < number) return;
    state.last = touch->time;
    state.triangle = number;
    state.corners = corners;
    state.normal = touch->normal;
    state.tolerance = bounds_.tolerance;
    const Vector local = part_.local_normal(touch->normal);
    for (int axis = 0; axis < 3; ++axis) normal_[axis] = local[axis];
  }

  const PosedPart& part_;
  const Surface& surface_;
  const MovingHull& hull_;
  const TouchBounds& bounds_;
  Axis lower_, upper_, middle_{}, half_{}, rate_{};
  double radius_ = 0, wider_ = 0;
  std::array<Axis, 8> offsets_{};  // points of the hull from its middle, if there are no more
  std::size_t few_ = 0;
  Vector axis_ = Vector::Zero();  // in the world, from the triangle before
  Axis normal_{};
};

/// A box of a frame and how the box of a hull moves there: the first time at which they meet, within `reach`.
std::optional<double> meets_box(const Eigen::AlignedBox3d& box, const Eigen::AlignedBox3d& hull, const Vector& way,
                                double reach, double last) {
  double enter = 0, leave = last;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box.min()[axis] - hull.max()[axis] - reach, high = box.max()[axis] - hull.min()[axis] + reach;
    const double first = way[axis] < 0 ? high : low, second = way[axis] < 0 ? low : high;
    if (first * way[axis] > 0) {
      // A way too short for its quotient leads to no time.
      if (!(std::abs(first) <= 2 * std::abs(way[axis]))) return std::nullopt;
      enter = std::max(enter, (1 - 4 * eps) * (first / way[axis]));
    }
    if (second * way[axis] < 0) return std::nullopt;
    if (way[axis] == 0 && (low > 0 || high < 0)) return std::nullopt;
    if (way[axis] != 0 && std::abs(second) <= 2 * std::abs(way[axis])) {
      leave = std::min(leave, (1 + 4 * eps) * (second / way[axis]));
    }
  }
  return enter <= leave ? std::optional(enter) : std::nullopt;
}

/// One hull and one body.
class VolumeCast {
 public:
  VolumeCast(const MovingHull& hull, const CastOptions& options) : hull_(hull), options_(options) {}

  /// Returns false if no part can change the answer any more.
  bool cast(const PosedPart& part) {
    FineLease lease;
    const Surface* fine = fine_surface(part.shape(), lease);
    if (fine == nullptr) {
      cast_at_cage(part);
      return true;
    }
    const TouchBounds bounds = bounds_for(part);
    switch (options_.solid ? interior(part.shape()) : Interior::none) {
      case Interior::none: break;
      case Interior::enclosed:
        if (locate(*fine, part.local(hull_.middle)) != Side::outside) state_.overlapping = true;
        break;
      case Interior::unknown: {
        Eigen::AlignedBox3d points;
        for (const Vector& p : hull_.points) points.extend(part.local(p));
        const std::optional<double> enter =
            meets_box({fine->lower.cast<double>(), fine->upper.cast<double>()}, points, part.local_direction(hull_.way),
                      part.farthest_local(bounds.distance), state_.last);
        if (!enter) return true;
        note_unknown(*enter);
        break;
      }
    }
    const std::int32_t before = state_.triangle;
    if (!state_.overlapping) CastSearch(part, *fine, hull_, bounds).search(state_);
    if (state_.triangle != before) convex_radius_ = convex_radius(part);
    return !state_.overlapping;
  }

  /// Casts at the parts of a compound that the hull comes near.
  void cast(const CompoundShape& compound, const Motion& motion) {
    const PosedParts parts(compound, motion);
    Eigen::AlignedBox3d points;
    for (const Vector& p : hull_.points) points.extend(parts.local(p));
    const Vector way = parts.local_direction(hull_.way);
    const double reach = (1 + 4 * rigid_tolerance) * hull_.radius / parts.scale() + parts.rounding(hull_.size);
    parts.visit(
        [&](const Eigen::AlignedBox3d& box) { return meets_box(box, points, way, reach, state_.last).has_value(); },
        [&](const MovingPart& part) { return cast(PosedPart(part)); });
  }

  CastResult result() const {
    CastResult result;
    if (state_.overlapping) {
      result.answer = CastAnswer::overlapping;
    } else if (unknown_ && *unknown_ <= state_.last) {
      result.time = *unknown_;
    } else if (state_.triangle >= 0) {
      result.answer = CastAnswer::hit;
      result.time = state_.last;
      result.triangle = state_.triangle;
      result.normal = state_.normal;
      // Along the normal the hull moves away from the place of the touch, which is ill defined where it is.
      const Vector moved = result.time * hull_.way + state_.tolerance * 64 * state_.normal;
      result.point = nearest_to_hull(hull_.points, moved, state_.corners).point + convex_radius_ * state_.normal;
    } else {
      result.answer = CastAnswer::miss;
      result.time = 1;
    }
    return result;
  }

 private:
  static double convex_radius(const PosedPart& part) { return part.scale() * part.shape().convex_radius; }

  TouchBounds bounds_for(const PosedPart& part) const {
    const double rounding = part.rounding(hull_.size + convex_radius(part));
    return {(hull_.radius + rounding + part.fine_error()) * (1 + 8 * eps), rounding,
            hull_.radius + convex_radius(part)};
  }

  void cast_at_cage(const PosedPart& part) {
    if (part.shape().cages.empty()) {
      note_unknown(0);
      return;
    }
    const Surface& cage = part.shape().cages.front();
    if (locate(cage, part.local(hull_.middle)) != Side::outside) {
      note_unknown(0);
      return;
    }
    CastState at_cage;
    CastSearch(part, cage, hull_, bounds_for(part)).search(at_cage);
    if (at_cage.triangle >= 0) note_unknown(at_cage.last);
  }

  /// Nothing later than that is of interest, other than what overlaps at the start.
  void note_unknown(double time) {
    if (!unknown_ || time < *unknown_) unknown_ = time;
    if (time < state_.last) state_.last = time;
  }

  const MovingHull& hull_;
  const CastOptions& options_;
  CastState state_;
  std::optional<double> unknown_;  // no proof from then on
  double convex_radius_ = 0;       // in the world, of the part that is hit
};

CastResult cast_hull(const Shape& shape, const Motion& motion, std::span<const Vector> points, double radius,
                     const Vector& way, const CastOptions& options) {
  CastResult result;
  const Motion at = start_of(motion);
  const auto usable = [](const Vector& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() <= largest_length; };
  if (!is_usable(at) || !usable(way) || !(radius >= 0 && radius <= largest_length)) return result;
  MovingHull hull{points, radius, way};
  for (const Vector& p : points) {
    if (!usable(p)) return result;
    hull.middle += p / static_cast<double>(points.size());
    hull.size = std::max(hull.size, p.norm());
  }
  hull.size += radius + way.norm();
  VolumeCast cast(hull, options);
  if (points.empty()) return cast.result();
  if (shape.is_compound()) {
    cast.cast(shape.compound(), at);
  } else {
    cast.cast(PosedPart(MovingPart{&shape.simple(), at}));
  }
  return cast.result();
}

}  // namespace

CastResult cast(const Shape& shape, const Motion& motion, std::span<const Vector> hull, double radius,
                const Vector& translation, const CastOptions& options) noexcept {
  return cast_hull(shape, motion, hull, radius, translation, options);
}

CastResult cast(const Shape& shape, const Motion& motion, const Sphere& sphere, const Vector& translation,
                const CastOptions& options) noexcept {
  return cast_hull(shape, motion, {&sphere.centre, 1}, sphere.radius, translation, options);
}

CastResult cast(const Shape& shape, const Motion& motion, const Capsule& capsule, const Vector& translation,
                const CastOptions& options) noexcept {
  const std::array<Vector, 2> ends = {capsule.a, capsule.b};
  return cast_hull(shape, motion, ends, capsule.radius, translation, options);
}

CastResult cast(const Shape& shape, const Motion& motion, const OrientedBox& box, const Vector& translation,
                const CastOptions& options) noexcept {
  BoxCorners corners;
  double rounding = 0;
  if (!corners_of(box, corners, rounding)) return {};
  return cast_hull(shape, motion, corners, rounding, translation, options);
}

}  // namespace encage
