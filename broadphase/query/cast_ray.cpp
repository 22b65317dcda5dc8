// SPDX-License-Identifier: Apache-2.0
#include "broadphase/query/near_parts.h"
#include "broadphase/query/ray_search.h"
#include "broadphase/query/rounded.h"
#include "broadphase/separation/containment.h"

#include <encage/fine_lease.h>
#include <encage/queries.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace encage {
namespace {

TriangleD corners_of(const Surface& surface, std::int32_t triangle) {
  const auto& v = surface.mesh.triangles[static_cast<std::size_t>(triangle)];
  const auto corner = [&](int k) { return surface.vertex(static_cast<std::int32_t>(v[static_cast<std::size_t>(k)])); };
  return {corner(0), corner(1), corner(2)};
}

RayHit described(const PosedPart& part, const Surface& surface, const LocalRay& ray, const FoundHit& found) {
  RayHit hit = describe_hit(part, ray, corners_of(surface, found.triangle), found.parameter);
  hit.triangle = found.triangle + part.first_triangle();
  return hit;
}

/// Bounds from below where a ray can enter the finest cage; no value if it is proven to stay outside.
std::optional<double> enters_cage(const PosedPart& part, const Ray& ray) {
  if (part.shape().cages.empty()) return std::nullopt;
  const Surface& cage = part.shape().cages.front();
  const std::optional<LocalRay> local = local_ray(part, cage, ray, {});
  if (!local) return std::nullopt;
  const Eigen::Vector3d from = part.local(ray.origin + std::max(ray.t_min, -1e300) * ray.direction);
  if (!from.allFinite() || locate(cage, from) != Side::outside) return ray.t_min;
  FoundHit found;
  if (!first_hit(cage, *local, found)) return std::nullopt;
  return local->t(found.parameter - local->certain);
}

/// One ray and one body.
class RayQuery {
 public:
  RayQuery(const Ray& ray, const RayOptions& options) : ray_(ray), options_(options) {}

  /// Looks for a hit before the one at hand, or as early in a triangle with a lower number.
  void cast(const PosedPart& part) {
    if (part.shape().convex_radius > 0) {
      visit_rounded(part, [&](const RayHit& hit) {
        const bool before =
            best_.triangle < 0 || hit.t < best_.t || (hit.t == best_.t && hit.triangle < best_.triangle);
        if (before) best_ = hit;
        return false;
      });
      return;
    }
    FineLease lease;
    const Surface* fine = fine_surface(part.shape(), lease);
    if (fine == nullptr) {
      note_cage(part);
      return;
    }
    const std::optional<LocalRay> local = local_ray(part, *fine, ray_, options_);
    if (!local) return;
    FoundHit found;
    if (best_.triangle >= 0) {
      // Equals count for parts with lower numbers, which need not come first.
      found = {best_.t, best_.t * local->size - local->shift + 4 * local->certain,
               best_.triangle - part.first_triangle()};
    }
    if (!first_hit(*fine, *local, found)) return;
    best_ = described(part, *fine, *local, found);
  }

  template <class Visit>
  bool visit_all(const PosedPart& part, Visit&& visit) {
    if (part.shape().convex_radius > 0) return visit_rounded(part, visit);
    FineLease lease;
    const Surface* fine = fine_surface(part.shape(), lease);
    if (fine == nullptr) {
      note_cage(part);
      return true;
    }
    const std::optional<LocalRay> local = local_ray(part, *fine, ray_, options_);
    if (!local) return true;
    const auto each = [&](const FoundHit& found) { return visit(described(part, *fine, *local, found)); };
    using Each = decltype(each);
    return every_hit(
        *fine, *local, [](void* context, const FoundHit& found) { return (*static_cast<Each*>(context))(found); },
        const_cast<void*>(static_cast<const void*>(&each)));
  }

  /// Calls visit for the parts of a compound that the ray comes near, near ones first.
  template <class Visit>
  bool for_each_part(const CompoundShape& compound, const Motion& motion, Visit&& visit) const {
    const PosedParts parts(compound, motion);
    const double size = ray_.direction.cwiseAbs().maxCoeff();
    const Eigen::Vector3d origin = parts.local(ray_.origin), direction = parts.local_direction(ray_.direction / size);
    const double slack = parts.rounding(ray_.origin.norm());
    const double low = ray_.t_min * size;
    return parts.visit_in_order(
        [&](const Eigen::AlignedBox3d& box) {
          double enter = low, leave = std::min(ray_.t_max, last()) * size;
          for (int axis = 0; axis < 3; ++axis) {
            double t0 = (box.min()[axis] - slack - origin[axis]) / direction[axis];
            double t1 = (box.max()[axis] + slack - origin[axis]) / direction[axis];
            if (!(std::abs(t0) <= 1e300 && std::abs(t1) <= 1e300)) {  // along the box, or nearly so
              if (origin[axis] < box.min()[axis] - slack || origin[axis] > box.max()[axis] + slack) return false;
              continue;
            }
            if (t0 > t1) std::swap(t0, t1);
            enter = std::max(enter, t0 - 8 * eps * std::abs(t0));
            leave = std::min(leave, t1 + 8 * eps * std::abs(t1));
          }
          return enter <= leave + slack * parts.scale();
        },
        visit,
        [&](const Eigen::AlignedBox3d& first, const Eigen::AlignedBox3d& second) {
          return direction.dot(second.min() + second.max() - first.min() - first.max()) < 0;
        });
  }

  RayResult result() const {
    RayResult result;
    if (unknown() && (best_.triangle < 0 || entered_ <= best_.t)) {
      result.hit.t = entered_;
      return result;
    }
    result.answer = best_.triangle < 0 ? RayAnswer::miss : RayAnswer::hit;
    result.hit = best_;
    return result;
  }
  bool unknown() const { return !std::isnan(entered_); }

 private:
  /// Visits the hits of a primitive with a convex radius, by increasing t.
  template <class Visit>
  bool visit_rounded(const PosedPart& part, Visit&& visit) {
    const RoundedHits found = cast_at_rounded(part, ray_, options_.back_faces == BackFaces::hit);
    if (found.unknown) note_entry(found.from);
    for (int i = 0; i < found.count; ++i) {
      if (!visit(found.hits[static_cast<std::size_t>(i)])) return false;
    }
    return true;
  }
  void note_cage(const PosedPart& part) { note_entry(enters_cage(part, ray_)); }
  void note_entry(const std::optional<double>& at) {
    if (at && !(entered_ <= *at)) entered_ = *at;
  }
  double last() const { return best_.triangle < 0 ? infinity : best_.t; }

  const Ray& ray_;
  const RayOptions& options_;
  RayHit best_;
  double entered_ = std::numeric_limits<double>::quiet_NaN();  // a body without a fine mesh, if a number
};

RayResult unknown_from(const Ray& ray) {
  RayResult result;
  result.hit.t = ray.t_min;
  return result;
}

RayResult cast(const PosedPart& part, const Ray& ray, const RayOptions& options) {
  if (!is_usable(ray)) return unknown_from(ray);
  RayQuery query(ray, options);
  if (ray.t_min <= ray.t_max) query.cast(part);
  return query.result();
}

RayResult cast(const CompoundShape& compound, const Motion& motion, const Ray& ray, const RayOptions& options) {
  if (!is_usable(ray)) return unknown_from(ray);
  RayQuery query(ray, options);
  if (ray.t_min <= ray.t_max) {
    query.for_each_part(compound, motion, [&](const MovingPart& part) {
      query.cast(PosedPart(part));
      return true;
    });
  }
  return query.result();
}

}  // namespace

void cast_rays(const Shape& shape, const Motion& motion, std::span<const Ray> asked, std::span<RayResult> results,
               const RayOptions& options) noexcept {
  const std::size_t count = std::min(asked.size(), results.size());
  const Motion at = start_of(motion);
  if (!is_usable(at)) {
    for (std::size_t i = 0; i < count; ++i) results[i] = unknown_from(asked[i]);
  } else if (shape.is_compound()) {
    for (std::size_t i = 0; i < count; ++i) results[i] = cast(shape.compound(), at, asked[i], options);
  } else {
    FineLease lease;
    fine_surface(shape.simple(), lease);
    const PosedPart part(MovingPart{&shape.simple(), at});
    for (std::size_t i = 0; i < count; ++i) results[i] = cast(part, asked[i], options);
  }
}

RayResult cast_ray(const Shape& shape, const Motion& motion, const Ray& ray, const RayOptions& options) noexcept {
  RayResult result;
  cast_rays(shape, motion, {&ray, 1}, {&result, 1}, options);
  return result;
}

RayAnswer visit_hits(const Shape& shape, const Motion& motion, const Ray& ray, const RayOptions& options,
                     bool (*visit)(void* context, const RayHit& hit), void* context) {
  const Motion at = start_of(motion);
  if (!is_usable(at) || !is_usable(ray)) return RayAnswer::unknown;
  if (!(ray.t_min <= ray.t_max)) return RayAnswer::miss;
  RayQuery query(ray, options);
  bool called = false;
  const auto call = [&](const RayHit& hit) {
    called = true;
    return visit(context, hit);
  };
  if (shape.is_compound()) {
    query.for_each_part(shape.compound(), at,
                        [&](const MovingPart& part) { return query.visit_all(PosedPart(part), call); });
  } else {
    query.visit_all(PosedPart(MovingPart{&shape.simple(), at}), call);
  }
  if (query.unknown()) return RayAnswer::unknown;
  return called ? RayAnswer::hit : RayAnswer::miss;
}

RayHits all_hits(const Shape& shape, const Motion& motion, const Ray& ray, std::span<RayHit> hits,
                 const RayOptions& options) noexcept {
  RayHits all;
  std::size_t kept = 0;
  all.answer = for_each_hit(shape, motion, ray, options, [&](const RayHit& hit) {
    ++all.count;
    const auto before = [](const RayHit& a, const RayHit& b) {
      return a.t < b.t || (a.t == b.t && a.triangle < b.triangle);
    };
    if (kept == hits.size()) {
      if (kept == 0 || !before(hit, hits[kept - 1])) return true;
    } else {
      ++kept;
    }
    std::size_t place = kept - 1;
    for (; place > 0 && before(hit, hits[place - 1]); --place) hits[place] = hits[place - 1];
    hits[place] = hit;
    return true;
  });
  if (all.answer == RayAnswer::unknown) all.count = 0;
  return all;
}

}  // namespace encage
