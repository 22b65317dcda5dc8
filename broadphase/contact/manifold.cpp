// SPDX-License-Identifier: Apache-2.0
#include "broadphase/contact/contact_search.h"
#include "broadphase/contact/manifold_reduction.h"
#include "broadphase/distance/resting_pair.h"
#include "broadphase/separation/plane_check.h"
#include "broadphase/shape/compound.h"

#include <encage/error.h>
#include <encage/fine_lease.h>
#include <encage/manifold.h>

#include <algorithm>
#include <cmath>
#include <string>
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

void refuse_unusable(const Motion& motion, const char* body) {
  if (!is_usable(motion)) throw Error(std::string("contact manifold: ") + body + ": " + motion_defect(motion));
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

/// Bounds how far the map moves points within `radius` of the origin.
double displacement(const AffineMap& map, double radius) {
  return (map.linear - Eigen::Matrix3d::Identity()).norm() * radius + map.offset.norm();
}

AffineMap local_to_local(const ContactBody& from, const ContactBody& to) { return composed(to.inverse, from.map); }

/// Bounds how far surfaces of the bodies, in world units, may have approached each other where they are near since
/// `then`, a map from b's local frame to a's.
double drift(const ContactScratch& search, const AffineMap& then) {
  const ContactBody &a = search.a, &b = search.b;
  const AffineMap now = local_to_local(b, a);
  return std::min(b.scale * displacement(composed(inverted(then), now), b.surface->radius),
                  a.scale * displacement(composed(then, inverted(now)), a.surface->radius));
}

/// The same for the motion of this step.
double drift_ahead(const ContactScratch& search) {
  const auto of = [](const ContactBody& body) {
    return body.scale * displacement(composed(body.inverse, composed(body.step, body.map)), body.surface->radius);
  };
  return std::min(of(search.a), of(search.b));
}

/// Bodies that move by no more than this many margins in a step are remembered.
constexpr double slow_margins = 8;
/// Margins by which bodies may move before what is remembered of them gets useless. A larger number costs time in the
/// steps that remember, and saves some of them.
constexpr double memory_margins = 1;

void search_with_memory(ContactScratch& search, const ContactQuery& query, double margin, ContactMemory& memory) {
  const double ahead = query.approach;
  const auto nothing = [&] { return memory.vertices_a.empty() && memory.vertices_b.empty() && memory.edges.empty(); };
  const ContactBody &a = search.a, &b = search.b;
  const bool same =
      memory.shape_a == a.shape && memory.shape_b == b.shape && memory.scale_a == a.scale && memory.scale_b == b.scale;
  if (memory.reach >= 0 && same) {
    const double approach = drift(search, memory.relative) + ahead;
    if (approach + std::max(0.0, query.limit - memory.limit) <= memory.reach) {
      find_contacts_again(search, query, memory, approach);
      if (nothing() || !search.candidates.empty()) return;
    }
  }
  memory.clear();
  const bool round = a.round || b.round;
  if (round || !(ahead <= slow_margins * margin)) return find_contacts(search, query, nullptr);
  memory.reach = memory_margins * margin + ahead;
  memory.relative = local_to_local(b, a);
  memory.limit = query.limit;
  memory.shape_a = a.shape;
  memory.shape_b = b.shape;
  memory.scale_a = a.scale;
  memory.scale_b = b.scale;
  find_contacts(search, query, &memory);
  // Contacts that come from no feature cannot be remembered: where leaves are near, the next query searches again.
  if (nothing() && !search.leaf_pairs.empty()) memory.clear();
}

}  // namespace

class ManifoldCache::State {
 public:
  std::vector<ContactSide> sides;  ///< sorted by feature
  std::vector<ContactSide> new_sides;
  ContactMemory memory;                 ///< of a pair that is no compound
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
ManifoldCache::ManifoldCache(const ManifoldCache& other) : state_(std::make_unique<State>(*other.state_)) {}
ManifoldCache& ManifoldCache::operator=(const ManifoldCache& other) {
  if (this != &other) *state_ = *other.state_;
  return *this;
}
ManifoldCache::ManifoldCache(ManifoldCache&& other) noexcept = default;
ManifoldCache& ManifoldCache::operator=(ManifoldCache&& other) noexcept = default;
void ManifoldCache::clear() noexcept {
  state_->sides.clear();
  state_->features.clear();
  state_->memory.clear();
}

int contact_manifold(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                     const ManifoldOptions& options, ManifoldCache& cache, std::span<ManifoldPoint> points) {
  ManifoldCache::State& state = cache.state();
  refuse_unusable(motion_a, "body a");
  refuse_unusable(motion_b, "body b");
  if (!valid(options, points)) return 0;
  Scratch& scratch = thread_scratch();
  ContactScratch& search = scratch.search;
  search.candidates.clear();
  const double radii = options.radius_a + options.radius_b;
  const Eigen::Vector3d origin = motion_a.start.translation();
  const bool compound = a.is_compound() || b.is_compound();
  bool tiles = false;
  const auto search_part = [&](const MovingPart& part_a, const MovingPart& part_b, bool for_tiles) {
    if (!part_a.shape->has_fine() || !part_b.shape->has_fine()) return true;
    const double radius_a = options.radius_a + part_a.motion.scale * part_a.shape->convex_radius;
    const double radius_b = options.radius_b + part_b.motion.scale * part_b.shape->convex_radius;
    const FineLease lease_a(*part_a.shape), lease_b(*part_b.shape);
    const RestingPair pair(part_a.shape->frame, part_a.motion, part_b.shape->frame, part_b.motion);
    search.a.place(part_a, pair.a, part_a.first_triangle);
    search.b.place(part_b, pair.b, part_b.first_triangle);
    const bool tile = search.a.is_tile() || search.b.is_tile();
    tiles = tiles || tile;
    const PairMotion motion = pair_motion(part_a.shape->frame, part_a.motion, part_b.shape->frame, part_b.motion);
    set_steps(search, part_a, part_b, pair.origin);
    const std::size_t first = search.candidates.size();
    const ContactQuery query{.motion = motion,
                             .limit = options.margin + radius_a + radius_b,
                             .error = pair.error + part_a.slack + part_b.slack,
                             .approach = drift_ahead(search),
                             .sides = state.sides,
                             .new_sides = state.new_sides,
                             .with_last_resort = !tile || for_tiles};
    if (compound) {
      find_contacts(search, query, nullptr);
    } else {
      search_with_memory(search, query, options.margin, state.memory);
    }
    const Eigen::Vector3d shift = pair.origin - origin;
    for (std::size_t i = first; i < search.candidates.size(); ++i) {
      ContactCandidate& c = search.candidates[i];
      c.separation -= radius_a + radius_b;
      c.point_a += shift - radius_a * c.normal;
      c.point_b += shift + radius_b * c.normal;
    }
    return true;
  };
  const auto search_all = [&](bool for_tiles) {
    for_each_part_pair(
        a, motion_a, b, motion_b, options.margin + radii,
        [&](const MovingPart& part_a, const MovingPart& part_b) { return search_part(part_a, part_b, for_tiles); });
  };
  search_all(false);
  // The contact of a tile may be its neighbour's. So the last resort is for where no tile has one.
  if (tiles && search.candidates.empty()) {
    state.new_sides.clear();
    search_all(true);
    std::vector<ContactCandidate>& found = search.candidates;
    const auto deepest = std::min_element(
        found.begin(), found.end(),
        [](const ContactCandidate& x, const ContactCandidate& y) { return x.separation < y.separation; });
    if (!found.empty()) {
      std::iter_swap(found.begin(), deepest);
      found.erase(found.begin() + 1, found.end());
    }
  }
  const int count = reduce_contacts(search.candidates, options, origin, state.features, scratch.reduction, points);
  state.keep(points.first(static_cast<std::size_t>(count)));
  return count;
}

int contact_manifold(const Shape& a, const Motion& motion_a, const HalfSpace& b, const ManifoldOptions& options,
                     ManifoldCache& cache, std::span<ManifoldPoint> points) {
  ManifoldCache::State& state = cache.state();
  refuse_unusable(motion_a, "body a");
  if (!valid(options, points)) return 0;
  if (!(std::abs(b.normal.norm() - 1) <= 1e-9) || !std::isfinite(b.offset)) return 0;
  Scratch& scratch = thread_scratch();
  ContactScratch& search = scratch.search;
  search.candidates.clear();
  const Eigen::Vector3d origin = motion_a.start.translation();
  for_each_part(a, motion_a, [&](const MovingPart& part) {
    if (!part.shape->has_fine()) return true;
    const double radius_a = options.radius_a + part.motion.scale * part.shape->convex_radius;
    const double radii = radius_a + options.radius_b;
    const FineLease lease(*part.shape);
    const LocalFrame& frame = part.shape->frame;
    IndexMap& seen = search.a.vertex_index;
    seen.clear(part.shape->fine.mesh.vertices.size());
    PlaneCheck(*part.shape, part.shape->fine, part.motion, b, options.margin + radii)
        .visit_reaching([&](std::int32_t v, double) {
          if (seen[v] >= 0 || part.shape->fine.is_foreign(v)) return;
          seen.insert(v, 0);
          const Eigen::Vector3d at =
              part.motion.start * (part.motion.scale * (frame.origin + part.shape->fine.vertex(v)));
          const double height = b.normal.dot(at) - b.offset;
          const double end =
              b.normal.dot(part.motion.end * (part.motion.scale * (frame.origin + part.shape->fine.vertex(v)))) -
              b.offset;
          if (!(std::min(height, end) <= options.margin + radii)) return;
          ContactCandidate c;
          c.point_a = at - origin - radius_a * b.normal;
          c.point_b = at - origin + (options.radius_b - height) * b.normal;
          c.normal = b.normal;
          c.separation = height - radii;
          c.feature = static_cast<std::uint64_t>(part.first_vertex) + static_cast<std::uint64_t>(v);
          search.candidates.push_back(c);
        });
    return true;
  });
  const int count = reduce_contacts(search.candidates, options, origin, state.features, scratch.reduction, points);
  state.keep(points.first(static_cast<std::size_t>(count)));
  return count;
}

}  // namespace encage
