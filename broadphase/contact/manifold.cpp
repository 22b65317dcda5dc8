// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/contact_search.h"
#include "broadphase/contact/manifold_reduction.h"
#include "broadphase/distance/resting_pair.h"
#include "broadphase/separation/plane_check.h"
#include "broadphase/shape/compound.h"

#include <encage/fine_lease.h>
#include <encage/manifold.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace encage {
namespace {

/// Working memory, which grows with the largest pair that a thread has seen.
struct Scratch {
  ContactScratch search;
  std::vector<ReductionEntry> reduction;
};

Scratch& thread_scratch() {
  thread_local Scratch scratch;
  return scratch;
}

bool valid(const ManifoldOptions& options, std::span<ManifoldPoint> points) {
  return options.margin >= 0 && options.radius_a >= 0 && options.radius_b >= 0 && !points.empty();
}

AffineMap end_map(const MovingPart& part, const Eigen::Vector3d& origin) {
  const Motion& motion = part.motion;
  return {motion.scale * motion.end.linear(), motion.end * (motion.scale * part.shape->frame.origin) - origin};
}

AffineMap composed(const AffineMap& outer, const AffineMap& inner) {
  return {outer.linear * inner.linear, outer(inner.offset)};
}

AffineMap inverted(const AffineMap& map) {
  const Eigen::Matrix3d inverse = map.linear.inverse();
  return {inverse, -(inverse * map.offset)};
}

/// How each part moves, seen from the other one. `origin` is that of the common frame, in the world.
void set_steps(ContactScratch& search, const MovingPart& a, const MovingPart& b, const Eigen::Vector3d& origin) {
  const AffineMap move_a = composed(end_map(a, origin), search.a.inverse),
                  move_b = composed(end_map(b, origin), search.b.inverse);
  search.a.step = composed(inverted(move_b), move_a);
  search.b.step = composed(inverted(move_a), move_b);
}

}  // namespace

class ManifoldCache::State {
 public:
  std::vector<ContactSide> sides;  ///< sorted by feature
  std::vector<ContactSide> new_sides;
  std::vector<std::uint64_t> features;  ///< chosen in the step before, in their order

  void keep(std::span<const ManifoldPoint> points) {
    sides.swap(new_sides);
    std::sort(sides.begin(), sides.end(),
              [](const ContactSide& x, const ContactSide& y) { return x.feature < y.feature; });
    new_sides.clear();
    features.clear();
    for (const ManifoldPoint& point : points) features.push_back(point.feature);
  }
};

ManifoldCache::ManifoldCache() : state_(std::make_unique<State>()) {}
ManifoldCache::~ManifoldCache() = default;
ManifoldCache::ManifoldCache(ManifoldCache&& other) noexcept = default;
ManifoldCache& ManifoldCache::operator=(ManifoldCache&& other) noexcept = default;
void ManifoldCache::clear() noexcept {
  state_->sides.clear();
  state_->features.clear();
}

int contact_manifold(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                     const ManifoldOptions& options, ManifoldCache& cache, std::span<ManifoldPoint> points) {
  ManifoldCache::State& state = cache.state();
  if (!valid(options, points) || !is_usable(motion_a) || !is_usable(motion_b)) return 0;
  auto& [search, reduction] = thread_scratch();
  search.candidates.clear();
  const double radii = options.radius_a + options.radius_b;
  const Eigen::Vector3d origin = motion_a.start.translation();
  for_each_part_pair(
      a, motion_a, b, motion_b, options.margin + radii, [&](const MovingPart& part_a, const MovingPart& part_b) {
        if (!part_a.shape->has_fine() || !part_b.shape->has_fine()) return true;
        const FineLease lease_a(*part_a.shape), lease_b(*part_b.shape);
        const RestingPair pair(part_a.shape->frame, part_a.motion, part_b.shape->frame, part_b.motion);
        search.a.place(part_a, pair.a, part_a.first_triangle);
        search.b.place(part_b, pair.b, part_b.first_triangle);
        const PairMotion motion = pair_motion(part_a.shape->frame, part_a.motion, part_b.shape->frame, part_b.motion);
        set_steps(search, part_a, part_b, pair.origin);
        const std::size_t first = search.candidates.size();
        find_contacts(search, motion, options.margin + radii, pair.error + part_a.slack + part_b.slack, state.sides,
                      state.new_sides);
        const Eigen::Vector3d shift = pair.origin - origin;
        for (std::size_t i = first; i < search.candidates.size(); ++i) {
          ContactCandidate& c = search.candidates[i];
          c.separation -= radii;
          c.point_a += shift - options.radius_a * c.normal;
          c.point_b += shift + options.radius_b * c.normal;
        }
        return true;
      });
  const int count = reduce_contacts(search.candidates, options, origin, state.features, reduction, points);
  state.keep(points.first(static_cast<std::size_t>(count)));
  return count;
}

int contact_manifold(const Shape& a, const Motion& motion_a, const HalfSpace& b, const ManifoldOptions& options,
                     ManifoldCache& cache, std::span<ManifoldPoint> points) {
  ManifoldCache::State& state = cache.state();
  if (!valid(options, points) || !is_usable(motion_a)) return 0;
  if (!(std::abs(b.normal.norm() - 1) <= 1e-9) || !std::isfinite(b.offset)) return 0;
  auto& [search, reduction] = thread_scratch();
  search.candidates.clear();
  const double radii = options.radius_a + options.radius_b;
  const Eigen::Vector3d origin = motion_a.start.translation();
  for_each_part(a, motion_a, [&](const MovingPart& part) {
    if (!part.shape->has_fine()) return true;
    const FineLease lease(*part.shape);
    const LocalFrame& frame = part.shape->frame;
    IndexMap& seen = search.a.vertex_index;
    seen.clear();
    PlaneCheck(*part.shape, part.shape->fine, part.motion, b, options.margin + radii)
        .visit_reaching([&](std::int32_t v, double) {
          if (std::exchange(seen[v], 0) == 0) return;
          const Eigen::Vector3d at =
              part.motion.start * (part.motion.scale * (frame.origin + part.shape->fine.vertex(v)));
          const double height = b.normal.dot(at) - b.offset;
          const double end =
              b.normal.dot(part.motion.end * (part.motion.scale * (frame.origin + part.shape->fine.vertex(v)))) -
              b.offset;
          if (!(std::min(height, end) <= options.margin + radii)) return;
          ContactCandidate c;
          c.point_a = at - origin - options.radius_a * b.normal;
          c.point_b = at - origin + (options.radius_b - height) * b.normal;
          c.normal = b.normal;
          c.separation = height - radii;
          c.feature = static_cast<std::uint64_t>(part.first_vertex + v);
          search.candidates.push_back(c);
        });
    return true;
  });
  const int count = reduce_contacts(search.candidates, options, origin, state.features, reduction, points);
  state.keep(points.first(static_cast<std::size_t>(count)));
  return count;
}

}  // namespace encage
