// SPDX-License-Identifier: Apache-2.0
#include "broadphase/distance/triangle_distance.h"
#include "broadphase/query/self_pairs.h"
#include "broadphase/shape/compound.h"
#include "src/limits.h"

#include <encage/error.h>
#include <encage/fine_lease.h>
#include <encage/self.h>

#include <algorithm>
#include <string>

namespace encage {
namespace {

// Tests of a box against eight that take as long as that of two triangles.
constexpr std::int64_t steps_of_neighbours = 8, steps_of_others = 24;

/// Finds the self-intersections of the parts of a shape.
struct IntersectionSearch {
  bool (*visit)(void* context, const SelfIntersection& found);
  void* context;
  std::int64_t steps;
  bool stopped = false;  ///< by the visitor
  const Surface* surface = nullptr;
  std::int32_t first_triangle = 0;

  /// Returns false if the visitor stopped it or the steps ended.
  bool run(const Surface& of, std::int32_t first) {
    surface = &of;
    first_triangle = first;
    return visit_self_pairs(
        of, 0,
        [](void* search, const LeafTriangle& a, const LeafTriangle& b) {
          return static_cast<IntersectionSearch*>(search)->look_at(a, b);
        },
        this, steps);
  }

  double look_at(const LeafTriangle& a, const LeafTriangle& b) {
    const SelfPair pair = self_pair(*surface, a, b);
    steps -= pair.shared > 0 ? steps_of_neighbours : steps_of_others;
    if (only_share(pair)) return 0;
    const SelfIntersection found{{first_triangle + pair.a, first_triangle + pair.b}, pair.shared, certainly_meet(pair)};
    stopped = !visit(context, found);
    return stopped ? -1 : 0;
  }
};

/// Finds the least distance of the triangles of one part.
struct NearestPairSearch {
  const Surface& surface;
  double limit, tolerance;
  std::int64_t& steps;
  double lower = infinity;  ///< over all pairs tested
  TriangleDistance best{0, infinity, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  TrianglePair triangles{-1, -1}, neighbours{-1, -1};
  bool neighbours_proven = false;

  /// The distance from which on pairs need not be tested.
  double reach() const { return std::min(limit, best.upper / (1 + tolerance)); }

  double look_at(const LeafTriangle& a, const LeafTriangle& b) {
    const SelfPair pair = self_pair(surface, a, b);
    if (pair.shared > 0) {
      if (neighbours.a >= 0) return reach();
      steps -= steps_of_neighbours;
      if (!only_share(pair)) {
        neighbours = {pair.a, pair.b};
        neighbours_proven = certainly_meet(pair);
      }
      return reach();
    }
    steps -= steps_of_others;
    // Corners are off by eps of the size together with 16 eps for rounding there.
    TriangleDistance found = triangle_distance(pair.corners_a, pair.corners_b, 20 * eps * pair.size + 1e-60);
    if (found.lower == 0 && certainly_meet(pair)) found.upper = 0;
    lower = std::min(lower, found.lower);
    if (found.upper < best.upper) {
      best = found;
      best.point_a += pair.origin;
      best.point_b += pair.origin;
      triangles = {pair.a, pair.b};
    }
    return reach();
  }
};

/// self_distance() of one part; points stay in its local frame.
SelfDistance part_self_distance(const Surface& surface, const SelfDistanceOptions& options, std::int64_t& steps) {
  NearestPairSearch search{.surface = surface, .limit = options.limit, .tolerance = options.tolerance, .steps = steps};
  const bool complete = visit_self_pairs(
      surface, options.limit,
      [](void* s, const LeafTriangle& a, const LeafTriangle& b) {
        return static_cast<NearestPairSearch*>(s)->look_at(a, b);
      },
      &search, steps);
  SelfDistance result;
  result.neighbours = search.neighbours;
  result.neighbours_proven = search.neighbours_proven;
  result.exhausted = !complete;
  result.lower = complete ? std::min(search.lower, search.reach()) : 0;
  if (search.best.upper < options.limit) {
    result.upper = search.best.upper;
    result.point_a = search.best.point_a;
    result.point_b = search.best.point_b;
    result.triangles = search.triangles;
  }
  return result;
}

/// Adds the result of a part, which is placed at rest.
void add(SelfDistance& all, const SelfDistance& part, const MovingPart& at, bool exact) {
  // The pose of a part is within 1e-10 of rigid, and the scale rounds.
  const double scale = at.motion.scale, off = exact ? 0 : 2e-10;
  all.lower = std::min(all.lower, scale * part.lower * (1 - off));
  all.exhausted = all.exhausted || part.exhausted;
  const auto numbered = [&](TrianglePair pair) {
    return TrianglePair{at.first_triangle + pair.a, at.first_triangle + pair.b};
  };
  if (all.neighbours.a < 0 && part.neighbours.a >= 0) {
    all.neighbours = numbered(part.neighbours);
    all.neighbours_proven = part.neighbours_proven;
  }
  const double upper = scale * part.upper * (1 + off);
  if (!(upper < all.upper)) return;
  const Eigen::Vector3d& origin = at.shape->frame.origin;
  all.upper = upper;
  all.point_a = at.motion.start * (scale * (origin + part.point_a));
  all.point_b = at.motion.start * (scale * (origin + part.point_b));
  all.triangles = numbered(part.triangles);
}

}  // namespace

VisitEnd visit_self_intersections(const Shape& shape, const SelfOptions& options,
                                  bool (*visit)(void* context, const SelfIntersection& found), void* context) {
  if (options.most_steps < 0) {
    throw Error("self-intersections: most_steps is " + std::to_string(options.most_steps) + ", below 0");
  }
  for_each_part(shape, Motion{}, [](const MovingPart& part) {
    if (!part.shape->has_fine()) throw Error("self-intersections: the shape or a part of it has no fine mesh");
    return true;
  });
  IntersectionSearch search{.visit = visit, .context = context, .steps = options.most_steps};
  const bool complete = for_each_part(shape, Motion{}, [&](const MovingPart& part) {
    const FineLease lease(*part.shape);
    return search.run(part.shape->fine, part.first_triangle);
  });
  return complete ? VisitEnd::complete : search.stopped ? VisitEnd::stopped : VisitEnd::exhausted;
}

SelfResult self_intersects(const Shape& shape, const SelfOptions& options) noexcept {
  SelfResult result;
  IntersectionSearch search{.visit =
                                [](void* context, const SelfIntersection& found) {
                                  auto& first = static_cast<SelfResult*>(context)->first;
                                  if (found.proven || first.triangles.a < 0) first = found;
                                  return !found.proven;
                                },
                            .context = &result,
                            .steps = options.most_steps};
  const bool complete = for_each_part(shape, Motion{}, [&](const MovingPart& part) {
    FineLease lease;
    return part.shape->has_fine() && lease.take(*part.shape) && search.run(part.shape->fine, part.first_triangle);
  });
  if (result.first.proven) {
    result.answer = SelfAnswer::crossing;
  } else if (!complete) {
    return {};
  } else {
    result.answer = result.first.triangles.a < 0 ? SelfAnswer::free : SelfAnswer::touching;
  }
  return result;
}

SelfDistance self_distance(const Shape& shape, const SelfDistanceOptions& options) noexcept {
  if (!(options.limit > 0) || !(options.tolerance >= 0) || options.most_steps < 0) return {};
  SelfDistance all;
  all.lower = options.limit;
  std::int64_t steps = options.most_steps;
  const bool asked = for_each_part(shape, Motion{}, [&](const MovingPart& part) {
    FineLease lease;
    if (!part.shape->has_fine() || !lease.take(*part.shape)) return false;
    SelfDistanceOptions of_part = options;
    of_part.limit = std::min(options.limit, all.upper) / part.motion.scale;
    add(all, part_self_distance(part.shape->fine, of_part, steps), part, !shape.is_compound());
    return true;
  });
  return asked ? all : SelfDistance{};
}

}  // namespace encage
