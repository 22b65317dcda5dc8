// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pose.h"
#include "broadphase/motion/turned_box.h"
#include "broadphase/query/half_space.h"
#include "broadphase/query/local_ray.h"
#include "broadphase/shape/world_box.h"
#include "broadphase/world/state.h"

#include <encage/world_queries.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <variant>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;
using Corner = std::array<double, 3>;

constexpr double left_out = std::numeric_limits<double>::quiet_NaN();

/// World units. How much wider than it is a box is taken, so that it holds whatever the query of a body may find: twice
/// the rounding that <encage/queries.h> promises, which also covers that of the comparison.
double slack_of(const Corner& lower, const Corner& upper, double norm) {
  double reach = norm;
  for (int k = 0; k < 3; ++k) reach += std::max(std::abs(lower[k]), std::abs(upper[k]));
  return 2e-13 * reach;
}

// ---- Questions of boxes --------------------------------------------------------

/// Tells where a ray enters boxes.
class RayBoxes {
 public:
  explicit RayBoxes(const Ray& ray) : size_(ray.direction.cwiseAbs().maxCoeff()), norm_(ray.origin.norm()) {
    for (int k = 0; k < 3; ++k) {
      origin_[k] = ray.origin[k];
      const double d = ray.direction[k] / size_;
      // Hardly any: on its way through finite boxes the ray moves along this axis by less than 1e-48.
      along_[k] = std::abs(d) > 1e-200;
      direction_[k] = along_[k] ? d : 1;
    }
    low_ = ray.t_min * size_;
    high_ = ray.t_max * size_;
  }

  /// Units of RayHit::t times size().
  double size() const { return size_; }

  double key(const Corner& lower, const Corner& upper) const {
    double slack = slack_of(lower, upper, norm_);
    // Hits on the planes of triangles that the ray grazes are off by this much.
    for (int k = 0; k < 3; ++k) slack = std::max(slack, 1e-6 * (upper[k] - lower[k]));
    double enter = low_ - 2 * slack, leave = high_ + 2 * slack;
    bool apart = false;
    for (int k = 0; k < 3; ++k) {
      const double below = lower[k] - slack - origin_[k], above = upper[k] + slack - origin_[k];
      if (!along_[k]) {
        apart = apart || below > 1e-45 || above < -1e-45;
        continue;
      }
      const double t0 = below / direction_[k], t1 = above / direction_[k];
      enter = std::max(enter, std::min(t0, t1));
      leave = std::min(leave, std::max(t0, t1));
    }
    return apart || enter > leave ? left_out : enter;
  }

 private:
  double size_, norm_, low_, high_;
  Corner origin_, direction_;
  std::array<bool, 3> along_;
};

/// Bounds distances of a point from boxes.
class PointBoxes {
 public:
  explicit PointBoxes(const Vector& point) : point_{point[0], point[1], point[2]}, norm_(point.norm()) {}

  double key(const Corner& lower, const Corner& upper) const {
    double squared = 0;
    for (int k = 0; k < 3; ++k) {
      const double apart = std::max({0.0, lower[k] - point_[k], point_[k] - upper[k]});
      squared += apart * apart;
    }
    return (1 - 16 * eps) * std::sqrt(squared) - slack_of(lower, upper, norm_);
  }

 private:
  Corner point_;
  double norm_;
};

/// Tells which boxes come near another box.
class BoxBoxes {
 public:
  explicit BoxBoxes(const Eigen::AlignedBox3d& box)
      : lower_{box.min()[0], box.min()[1], box.min()[2]}, upper_{box.max()[0], box.max()[1], box.max()[2]} {
    for (int k = 0; k < 3; ++k) norm_ += std::max(std::abs(lower_[k]), std::abs(upper_[k]));
  }

  double key(const Corner& lower, const Corner& upper) const {
    const double slack = slack_of(lower, upper, norm_);
    bool apart = false;
    for (int k = 0; k < 3; ++k) apart = apart || lower[k] - slack > upper_[k] || upper[k] + slack < lower_[k];
    return apart ? left_out : 0;
  }

 private:
  Corner lower_, upper_;
  double norm_ = 0;
};

/// Tells which boxes reach a half-space.
class HalfSpaceBoxes {
 public:
  explicit HalfSpaceBoxes(const HalfSpace& half_space) : half_space_(half_space) {}
  double key(const Corner& lower, const Corner& upper) const {
    const Eigen::AlignedBox3d box(Vector(lower.data()), Vector(upper.data()));
    return box_beyond(box, half_space_, slack_of(lower, upper, 0)) ? left_out : 0;
  }

 private:
  const HalfSpace& half_space_;
};

}  // namespace

// ---- Objects of a world --------------------------------------------------------

/// One query of a world: the objects that it has to ask.
class ENCAGE_HIDDEN WorldQuery {
 public:
  WorldQuery(const World& world, const WorldQueryOptions& options) : state_(*world.state_), options_(options) {}

  /// Calls visit(object, shape, motion) for the bodies whose boxes have keys up to bound(), near ones first.
  template <class Boxes, class Bound, class Visit>
  void nearest_first(const Boxes& boxes, const Bound& bound, Visit&& visit) const {
    find(boxes, bound, [&](std::uint32_t n) {
      const WorldObject object{.body = state_.body_ids().at(n)};
      const World::State::Body& body = state_.body_at(n);
      if (takes(body) && accepts(object)) visit(object, state_.shape_at(n), body.motion);
    });
  }

  /// Calls visit(object, shape, motion) -> bool for the bodies whose boxes have keys, by increasing index, until it
  /// returns false; returns false if it did.
  template <class Boxes, class Visit>
  bool in_order(const Boxes& boxes, Visit&& visit) const {
    // The least indices that have not been visited, as a heap.
    std::array<std::uint32_t, 256> found;
    std::uint32_t first = 0;
    for (bool more = true; more;) {
      std::size_t size = 0;
      more = false;
      find(
          boxes, [] { return infinity; },
          [&](std::uint32_t n) {
            if (n < first || !takes(state_.body_at(n))) return;
            if (size == found.size()) {
              more = true;
              if (n > found.front()) return;
              std::pop_heap(found.begin(), found.end());
              --size;
            }
            found[size++] = n;
            std::push_heap(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(size));
          });
      std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(size));
      for (std::size_t i = 0; i < size; ++i) {
        const WorldObject object{.body = state_.body_ids().at(found[i])};
        if (!meets(boxes, found[i]) || !accepts(object)) continue;
        if (!visit(object, state_.shape_at(found[i]), state_.body_at(found[i]).motion)) return false;
      }
      if (more) first = found[size - 1] + 1;
    }
    return true;
  }

  /// Calls visit(object, half-space) -> bool for the half-spaces in their order, until it returns false; returns false
  /// if it did.
  template <class Visit>
  bool half_spaces(Visit&& visit) const {
    if (!options_.half_spaces) return true;
    for (std::uint32_t p = 0; p < state_.plane_ids().slots(); ++p) {
      if (!state_.plane_ids().is_used(p) || !allows(state_.plane_at(p).filter)) continue;
      const WorldObject object{.half_space = state_.plane_ids().at(p)};
      if (accepts(object) && !visit(object, state_.plane_at(p).half_space)) return false;
    }
    return true;
  }

 private:
  /// Calls visit(index) for the bodies whose boxes have keys up to bound(). Boxes in the tree hold whole motions, and
  /// margins; they are only larger than necessary.
  template <class Boxes, class Bound, class Visit>
  void find(const Boxes& boxes, const Bound& bound, Visit&& visit) const {
    const BodyTree& tree = state_.tree();
    const auto keys = [&](const BoxLanes& lanes) {
      std::array<double, BoxLanes::width> all;
      for (int lane = 0; lane < BoxLanes::width; ++lane) {
        Corner lower, upper;
        for (int k = 0; k < 3; ++k) {
          lower[k] = static_cast<double>(lanes.lower[k][lane]);
          upper[k] = static_cast<double>(lanes.upper[k][lane]);
        }
        all[lane] = boxes.key(lower, upper);
      }
      return all;
    };
    tree.query_in_order(keys, bound, visit);
    for (const BodyTree::Leaf leaf : tree.stale()) {
      const std::uint32_t n = tree.item(leaf);
      const Motion& motion = state_.body_at(n).motion;
      if (key_of(boxes, ball_box(state_.shape_at(n), {motion.start, motion.scale})) <= bound()) visit(n);
    }
  }

  /// True if the box of the body where it starts has a key: whatever the tree knew, the same bodies are left.
  template <class Boxes>
  bool meets(const Boxes& boxes, std::uint32_t n) const {
    const Motion& motion = state_.body_at(n).motion;
    return !std::isnan(key_of(boxes, usable_box(state_.shape_at(n), Motion::resting(motion.start, motion.scale))));
  }
  template <class Boxes>
  static double key_of(const Boxes& boxes, const Eigen::AlignedBox3d& box) {
    return boxes.key({box.min()[0], box.min()[1], box.min()[2]}, {box.max()[0], box.max()[1], box.max()[2]});
  }

  bool allows(const Filter& filter) const {
    return !options_.filter ||
           ((options_.filter->category & filter.mask) != 0 && (filter.category & options_.filter->mask) != 0);
  }
  bool takes(const World::State::Body& body) const {
    return (options_.sensors || !body.options.sensor) && allows(body.options.filter);
  }
  bool accepts(const WorldObject& object) const { return !options_.accept || options_.accept(object); }

  const World::State& state_;
  const WorldQueryOptions& options_;
};

namespace {

bool before(const WorldObject& a, const WorldObject& b) {
  const bool body_a = a.body != BodyId::none, body_b = b.body != BodyId::none;
  if (body_a != body_b) return body_a;
  return body_a ? index(a.body) < index(b.body) : index(a.half_space) < index(b.half_space);
}

// ---- Rays ----------------------------------------------------------------------

/// The earlier of two hits, for the first one of all.
bool before(const WorldRayHit& a, const WorldRayHit& b) {
  if (a.hit.t != b.hit.t) return a.hit.t < b.hit.t;
  if (a.answer != b.answer) return a.answer == RayAnswer::unknown;
  return before(a.object, b.object);
}

WorldRayHit first_hit_of(const WorldQuery& query, const Ray& ray, const RayOptions& options) {
  WorldRayHit best;
  if (!is_usable(ray)) {
    best.answer = RayAnswer::unknown;
    best.hit.t = ray.t_min;
    return best;
  }
  if (!(ray.t_min <= ray.t_max)) return best;
  const RayBoxes boxes(ray);
  double bound = infinity;  // of parameters
  const auto note = [&](const WorldRayHit& found) {
    if (best.answer != RayAnswer::miss && !before(found, best)) return;
    best = found;
    bound = best.hit.t * boxes.size();
    if (std::isfinite(bound)) bound += 8 * eps * std::abs(bound);
  };
  query.nearest_first(
      boxes, [&] { return bound; },
      [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
        const RayResult result = cast_ray(shape, motion, ray, options);
        if (result.answer != RayAnswer::miss) note({result.answer, object, result.hit});
      });
  query.half_spaces([&](const WorldObject& object, const HalfSpace& half_space) {
    if (const std::optional<RayHit> hit = plane_hit(half_space, ray, options)) note({RayAnswer::hit, object, *hit});
    return true;
  });
  return best;
}

// ---- Volumes -------------------------------------------------------------------

/// A volume as the convex hull of points, widened by a radius; a half-space has no points.
class AskedVolume {
 public:
  explicit AskedVolume(const Volume& volume) : volume_(volume) {
    std::visit([this](const auto& asked) { take(asked); }, volume);
    if (half_space() != nullptr) return;
    bad_ = bad_ || !(radius_ >= 0 && radius_ <= largest_length);
    for (const Vector& p : points_) {
      bad_ = bad_ || !p.allFinite() || !(p.cwiseAbs().maxCoeff() <= largest_length);
      if (!bad_) box_.extend(p);
    }
    if (bad_) {
      box_ = {Vector::Constant(-infinity), Vector::Constant(infinity)};
    } else if (!points_.empty()) {
      box_ = {box_.min().array() - radius_, box_.max().array() + radius_};
    }
  }
  AskedVolume(const AskedVolume&) = delete;
  AskedVolume& operator=(const AskedVolume&) = delete;

  const HalfSpace* half_space() const { return std::get_if<HalfSpace>(&volume_); }
  bool is_empty() const { return half_space() == nullptr && !bad_ && points_.empty(); }
  const Eigen::AlignedBox3d& box() const { return box_; }

  bool overlaps_body(const Shape& shape, const Motion& motion) const {
    return std::visit(
        [&](const auto& asked) {
          if constexpr (std::is_same_v<decltype(asked), const Hull&>) {
            return overlaps(shape, motion, asked.points, asked.radius);
          } else {
            return overlaps(shape, motion, asked);
          }
        },
        volume_);
  }
  bool overlaps_plane(const HalfSpace& plane) const {
    if (bad_) return true;
    return half_space() != nullptr ? half_spaces_meet(*half_space(), plane) : reaches_plane(plane, points_, radius_);
  }

 private:
  void take(const Sphere& sphere) {
    points_ = {&sphere.centre, 1};
    radius_ = sphere.radius;
  }
  void take(const Capsule& capsule) {
    own_[0] = capsule.a;
    own_[1] = capsule.b;
    points_ = {own_.data(), 2};
    radius_ = capsule.radius;
  }
  void take(const OrientedBox& box) {
    bad_ = !is_usable(box.pose) || !(box.half.minCoeff() >= 0) || !box.half.allFinite();
    for (unsigned i = 0; i < 8; ++i) {
      const Vector sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
      own_[i] = box.pose * Vector(sign.cwiseProduct(box.half));
    }
    points_ = own_;
    // Rounding of the corners, as for one body.
    radius_ = 16 * eps * (box.half.norm() + box.pose.translation().norm());
  }
  void take(const HalfSpace& half_space) { bad_ = !half_space.normal.allFinite() || !std::isfinite(half_space.offset); }
  void take(const Hull& hull) {
    points_ = hull.points;
    radius_ = hull.radius;
    if (points_.empty()) radius_ = 0;  // nothing at all, whatever the radius
  }

  const Volume& volume_;
  std::array<Vector, 8> own_;
  std::span<const Vector> points_{};
  double radius_ = 0;
  bool bad_ = false;
  Eigen::AlignedBox3d box_;
};

bool ask_overlaps(const WorldQuery& query, const AskedVolume& volume,
                  bool (*visit)(void* context, const WorldObject& object), void* context) {
  if (volume.is_empty()) return true;
  const auto each_body = [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
    return !volume.overlaps_body(shape, motion) || visit(context, object);
  };
  const bool on = volume.half_space() != nullptr ? query.in_order(HalfSpaceBoxes(*volume.half_space()), each_body)
                                                 : query.in_order(BoxBoxes(volume.box()), each_body);
  return on && query.half_spaces([&](const WorldObject& object, const HalfSpace& half_space) {
    return !volume.overlaps_plane(half_space) || visit(context, object);
  });
}

bool is_point(const Vector& point) { return point.allFinite() && point.cwiseAbs().maxCoeff() <= largest_length; }

}  // namespace

// ---- Rays ----------------------------------------------------------------------

WorldRayHit cast_ray(const World& world, const Ray& ray, const RayOptions& ray_options,
                     const WorldQueryOptions& options) {
  return first_hit_of(WorldQuery(world, options), ray, ray_options);
}

void cast_rays(const World& world, std::span<const Ray> asked, std::span<WorldRayHit> results,
               const RayOptions& ray_options, const WorldQueryOptions& options) {
  const WorldQuery query(world, options);
  const std::size_t count = std::min(asked.size(), results.size());
  for (std::size_t i = 0; i < count; ++i) results[i] = first_hit_of(query, asked[i], ray_options);
}

RayAnswer visit_hits(const World& world, const Ray& ray, const RayOptions& ray_options,
                     const WorldQueryOptions& options, bool (*visit)(void* context, const WorldRayHit& hit),
                     void* context) {
  if (!is_usable(ray)) return RayAnswer::unknown;
  if (!(ray.t_min <= ray.t_max)) return RayAnswer::miss;
  const WorldQuery query(world, options);
  bool unknown = false, called = false;
  const auto each_body = [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
    bool on = true;
    const RayAnswer answer = for_each_hit(shape, motion, ray, ray_options, [&](const RayHit& hit) {
      called = true;
      return on = visit(context, {RayAnswer::hit, object, hit});
    });
    if (answer != RayAnswer::unknown) return on;
    unknown = true;
    if (!on) return false;
    // Hits that are not known come no earlier than the first one of all.
    WorldRayHit entry{RayAnswer::unknown, object, {}};
    entry.hit.t = cast_ray(shape, motion, ray, ray_options).hit.t;
    return visit(context, entry);
  };
  if (query.in_order(RayBoxes(ray), each_body)) {
    query.half_spaces([&](const WorldObject& object, const HalfSpace& half_space) {
      const std::optional<RayHit> hit = plane_hit(half_space, ray, ray_options);
      if (!hit) return true;
      called = true;
      return visit(context, {RayAnswer::hit, object, *hit});
    });
  }
  return unknown ? RayAnswer::unknown : called ? RayAnswer::hit : RayAnswer::miss;
}

RayHits all_hits(const World& world, const Ray& ray, std::span<WorldRayHit> hits, const RayOptions& ray_options,
                 const WorldQueryOptions& options) {
  const auto earlier = [](const WorldRayHit& a, const WorldRayHit& b) {
    if (a.hit.t != b.hit.t) return a.hit.t < b.hit.t;
    return a.object == b.object ? a.hit.triangle < b.hit.triangle : before(a.object, b.object);
  };
  RayHits all;
  std::size_t kept = 0;
  all.answer = for_each_hit(world, ray, ray_options, options, [&](const WorldRayHit& hit) {
    ++all.count;
    if (kept == hits.size()) {
      if (kept == 0 || !earlier(hit, hits[kept - 1])) return true;
    } else {
      ++kept;
    }
    std::size_t place = kept - 1;
    for (; place > 0 && earlier(hit, hits[place - 1]); --place) hits[place] = hits[place - 1];
    hits[place] = hit;
    return true;
  });
  return all;
}

// ---- Points --------------------------------------------------------------------

WorldClosestPoint closest_point(const World& world, const Vector& point, const ClosestPointOptions& point_options,
                                const WorldQueryOptions& options) {
  WorldClosestPoint best;
  if (!is_point(point) || !(point_options.limit > 0)) return best;
  double lower = point_options.limit;
  const auto note = [&](const WorldObject& object, const ClosestPoint& found) {
    lower = std::min(lower, found.lower);
    if (found.upper == infinity) return;
    if (!best.found() || found.upper < best.closest.upper ||
        (found.upper == best.closest.upper && before(object, best.object))) {
      best = {object, found};
    }
  };
  const WorldQuery query(world, options);
  query.nearest_first(
      PointBoxes(point), [&] { return std::min(point_options.limit, best.closest.upper); },
      [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
        note(object, closest_point(shape, motion, point, point_options));
      });
  query.half_spaces([&](const WorldObject& object, const HalfSpace& half_space) {
    note(object, closest_on_plane(half_space, point, point_options.limit));
    return true;
  });
  best.closest.lower = std::min(lower, best.closest.upper);
  return best;
}

PointSide visit_objects_at(const World& world, const Vector& point, const WorldQueryOptions& options,
                           bool (*visit)(void* context, const WorldObject& object, PointSide side), void* context) {
  const WorldQuery query(world, options);
  const bool usable = is_point(point);
  bool inside = false, unknown = !usable;
  const auto note = [&](const WorldObject& object, PointSide side) {
    if (side == PointSide::outside) return true;
    inside = inside || side == PointSide::inside;
    unknown = unknown || side == PointSide::unknown;
    return visit(context, object, side);
  };
  const auto each_body = [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
    return note(object, contains(shape, motion, point));
  };
  // Every body may contain a point that is none.
  Eigen::AlignedBox3d box(point);
  if (!usable) box = {Vector::Constant(-infinity), Vector::Constant(infinity)};
  if (query.in_order(BoxBoxes(box), each_body)) {
    query.half_spaces([&](const WorldObject& object, const HalfSpace& half_space) {
      return note(object, usable ? plane_side(half_space, point) : PointSide::unknown);
    });
  }
  return inside ? PointSide::inside : unknown ? PointSide::unknown : PointSide::outside;
}

// ---- Volumes -------------------------------------------------------------------

bool visit_overlaps(const World& world, const Volume& volume, const WorldQueryOptions& options,
                    bool (*visit)(void* context, const WorldObject& object), void* context) {
  return ask_overlaps(WorldQuery(world, options), AskedVolume(volume), visit, context);
}

bool overlaps(const World& world, const Volume& volume, const WorldQueryOptions& options) {
  return !for_each_overlap(world, volume, options, [](const WorldObject&) { return false; });
}

}  // namespace encage
