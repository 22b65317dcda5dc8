// SPDX-License-Identifier: Apache-2.0
#include "broadphase/distance/surface_distance.h"

#include "broadphase/distance/box_distance.h"
#include "broadphase/distance/triangle_distance.h"
#include "broadphase/separation/leaf_gate.h"

#include <algorithm>

namespace encage {
namespace {

class DistanceSearch {
  static constexpr std::int64_t steps_of_row = 1, steps_of_triangles = 24;

 public:
  DistanceSearch(const ScaledSurface& a, const ScaledSurface& b, const RestingPair& pair,
                 const SurfaceDistanceOptions& options)
      : a_(a), b_(b), pair_(pair), options_(options), tolerance_(options.tolerance) {}

  SurfaceDistance run() {
    if (in_range(a_, options_.hint.a) && in_range(b_, options_.hint.b)) {
      look_at(corners(a_, pair_.a, options_.hint.a), corners(b_, pair_.b, options_.hint.b), options_.hint.a,
              options_.hint.b);
    }
    const BoxDistance bounds(pair_.a, {a_->radius, a_->tree.grid, a_.scale()}, pair_.b,
                             {b_->radius, b_->tree.grid, b_.scale()}, pair_.error);
    std::int64_t unlimited = std::numeric_limits<std::int64_t>::max();
    std::int64_t& steps = options_.steps == nullptr ? unlimited : *options_.steps;
    // Coarser bounds are found sooner where very many pairs are equally near: some steps are kept for them.
    constexpr double coarse[] = {0x1p-12, 0x1p-6};
    const std::int64_t kept = steps / 16;
    // Far from each other bodies' boxes drown in rounding, and all leaves have to be seen.
    const bool far = steps < std::int64_t{1} << 60 && pair_.b.offset.norm() > 0x1p36 * (a_.radius() + b_.radius());
    best_.lower = search(bounds, (far ? 4 * steps : steps) - 2 * kept, steps);
    best_.exhausted = left_ < 0 && limit() > 0;
    for (const double coarser : coarse) {
      if (left_ >= 0 || limit() < 0 || coarser < options_.tolerance) continue;
      tolerance_ = coarser;
      best_.lower = std::max(best_.lower, search(bounds, kept, steps));
    }
    if (limit() < 0) best_.lower = 0;
    return best_;
  }

 private:
  static bool in_range(const ScaledSurface& surface, std::int32_t triangle) {
    return triangle >= 0 && static_cast<std::size_t>(triangle) < surface->mesh.triangles.size();
  }

  /// Returns the distance from which on pairs need not be tested; minus infinity if the surfaces touch within rounding.
  double limit() const {
    if (best_.crossing || best_.upper <= 4 * pair_.error) return -std::numeric_limits<double>::infinity();
    // Pairs that are equally near cannot improve the result: this leaves out those that lanes_not_apart() finds as
    // near, but for its own rounding.
    return std::min(options_.limit, (best_.upper - 2.0625 * pair_.error) / (1 + tolerance_));
  }

  /// Returns a lower bound of the distance, or of the limit. Takes `most` steps at most.
  double search(const BoxDistance& bounds, std::int64_t most, std::int64_t& steps) {
    left_ = most;
    const double unvisited = visit_near_leaves(
        a_->tree, b_->tree, bounds, limit(),
        [](void* search, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
          return static_cast<DistanceSearch*>(search)->leaves(first_a, count_a, first_b, count_b);
        },
        this, &left_);
    steps -= most - left_;
    return std::max(0.0, std::min({lower_, limit(), unvisited}));
  }

  static TriangleD corners(const ScaledSurface& surface, const AffineMap& map, std::int32_t triangle) {
    TriangleD t;
    for (int k = 0; k < 3; ++k) {
      t[k] = map(surface.vertex(static_cast<std::int32_t>(surface->mesh.triangles[triangle][k])));
    }
    return t;
  }

  static LeafLanes lanes(const ScaledSurface& surface, const AffineMap& map, std::int32_t first, std::int32_t count) {
    LeafLanes result;
    MovingTriangle triangle;
    for (std::int32_t i = 0; i < LeafLanes::width; ++i) {
      for (int k = 0; k < 3 && i < count; ++k) {
        triangle.start[k] = map(surface.vertex(surface->tree.leaves[first + i].vertices[k]));
      }
      result.set(i, triangle, 1);
    }
    return result;
  }

  void look_at(const TriangleD& ta, const TriangleD& tb, std::int32_t i, std::int32_t j) {
    const TriangleDistance found = triangle_distance(ta, tb, pair_.error);
    lower_ = std::min(lower_, found.lower);
    if (found.upper < best_.upper) {
      best_.upper = found.upper;
      best_.point_a = found.point_a;
      best_.point_b = found.point_b;
      best_.triangle_a = i;
      best_.triangle_b = j;
    }
    if (found.lower > 0) return;
    best_.crossing = triangles_cross(ta, tb, pair_.error + options_.vertex_error);
  }

  double leaves(std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
    const LeafLanes lanes_a = lanes(a_, pair_.a, first_a, count_a), lanes_b = lanes(b_, pair_.b, first_b, count_b);
    left_ -= steps_of_row * count_a;
    for (std::int32_t i = 0; i < count_a; ++i) {
      std::uint32_t left = (1U << count_b) - 1;
      double asked = std::numeric_limits<double>::infinity();
      for (; left != 0; left &= left - 1) {
        if (limit() < asked) {  // axes that are cheap to try prove most pairs farther apart
          asked = limit();
          if (asked < 0) return asked;
          left &= lanes_not_apart(lanes_a, i, lanes_b, count_b, 1, asked + pair_.error);
          if (left == 0) break;
        }
        const int j = __builtin_ctz(left);
        left_ -= steps_of_triangles;
        look_at(lanes_a.triangle(i, 1).start, lanes_b.triangle(j, 1).start, a_->tree.leaves[first_a + i].triangle,
                b_->tree.leaves[first_b + j].triangle);
      }
    }
    return limit();
  }

  const ScaledSurface& a_;
  const ScaledSurface& b_;
  const RestingPair& pair_;
  const SurfaceDistanceOptions& options_;
  double tolerance_;
  std::int64_t left_ = 0;                                   // of the steps of this search
  double lower_ = std::numeric_limits<double>::infinity();  // over all pairs tested
  SurfaceDistance best_;
};

}  // namespace

SurfaceDistance surface_distance(const ScaledSurface& a, const ScaledSurface& b, const RestingPair& pair,
                                 const SurfaceDistanceOptions& options) noexcept {
  return DistanceSearch(a, b, pair, options).run();
}

}  // namespace encage
