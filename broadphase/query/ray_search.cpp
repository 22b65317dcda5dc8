// SPDX-License-Identifier: Apache-2.0
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/query/ray_search.cpp"
#include <hwy/foreach_target.h>  // compiles the following once for every instruction set

#include "broadphase/query/ray_search.h"

#include "broadphase/shape/leaf_corners-inl.h"
#include "src/tree/visit.h"

#include <Eigen/Geometry>
#include <hwy/highway.h>
// clang-format on

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace {

// ---- Boxes ---------------------------------------------------------------------

using RayBoxLanes = hn::CappedTag<float, MeshNode::width>;

template <class Integer>
HWY_INLINE hn::Vec<RayBoxLanes> lanes_of(const Integer* from) {
  const RayBoxLanes d;
  const hn::Rebind<Integer, RayBoxLanes> from_type;
  const hn::Rebind<std::int32_t, RayBoxLanes> wide;
  return hn::ConvertTo(d, hn::PromoteTo(wide, hn::LoadU(from_type, from)));
}

/// The ray in grid coordinates, in float. Its parameter counts grid steps along the largest coordinate; within the
/// surface it is at most 2^18. Coordinates are off by less than 2^-4 of a step besides LocalRay::error, which `slack`
/// covers (docs/guarantee.md, "Queries of one body").
struct GridRay {
  std::array<float, 3> near, far;  ///< the origin, moved by the slack against and along the direction
  std::array<float, 3> inverse;    ///< 1 / direction
  std::array<bool, 3> backward;
  std::array<float, 3> origin, direction;
  float slab_slack;  ///< of heights along a slab's normal
  float place;       ///< slack of parameters
  float low, high;
  double steps;  ///< per unit of the ray's own parameter

  GridRay(const LocalRay& ray, const TreeGrid& grid) {
    const double step = static_cast<double>(grid.step);
    steps = ray.direction.cwiseAbs().maxCoeff() / step;
    const double slack = 0.125 + grid.rounding() + 4 * ray.error / step;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<Eigen::Index>(axis);
      origin[axis] = bounded(grid.coordinate(static_cast<int>(axis), ray.origin[i]));
      // Over the whole surface a direction below this leads nowhere.
      constexpr double least = 1e-18;
      const double along = ray.direction[i] / step / steps;
      backward[axis] = along < 0;
      const double bent = std::copysign(std::max(std::abs(along), least), backward[axis] ? -1.0 : 1.0);
      direction[axis] = static_cast<float>(bent);
      inverse[axis] = static_cast<float>(1 / bent);
      const float moved = bounded(backward[axis] ? -slack : slack);
      near[axis] = origin[axis] + moved;
      far[axis] = origin[axis] - moved;
    }
    slab_slack = bounded(128 + 256 * slack);
    place = bounded(0.25 + 4 * grid.rounding() + 64 * ray.error / step);
    low = parameter(ray.low) - place;
    high = limit(ray.high);
  }

  static float bounded(double x) { return static_cast<float>(std::clamp(x, -1e30, 1e30)); }
  float parameter(double p) const { return bounded(p * steps); }
  /// Nothing beyond it can be met up to p.
  float limit(double p) const {
    const float at = parameter(p);
    return at + place + 1e-6F * std::abs(at);
  }
};

/// Computes where the ray enters boxes and slabs, and returns a bit for each lane that it may meet up to `limit`.
HWY_INLINE unsigned meet_boxes(const GridRay& ray, const MeshNode& node, float limit,
                               std::array<float, MeshNode::width>& enter) {
  const RayBoxLanes d;
  unsigned met = 0;
  for (std::size_t first = 0; first < static_cast<std::size_t>(MeshNode::width); first += hn::Lanes(d)) {
    auto in = hn::Set(d, ray.low), out = hn::Set(d, limit);
    auto height = hn::Zero(d), rate = hn::Zero(d);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto low = lanes_of(node.lower[axis] + first), high = lanes_of(node.upper[axis] + first);
      const auto inverse = hn::Set(d, ray.inverse[axis]);
      const bool backward = ray.backward[axis];
      in = hn::Max(in, hn::Mul(hn::Sub(backward ? high : low, hn::Set(d, ray.near[axis])), inverse));
      out = hn::Min(out, hn::Mul(hn::Sub(backward ? low : high, hn::Set(d, ray.far[axis])), inverse));
      const auto n = lanes_of(node.normal[axis] + first);
      height = hn::MulAdd(n, hn::Set(d, ray.origin[axis]), height);
      rate = hn::MulAdd(n, hn::Set(d, ray.direction[axis]), rate);
    }
    const auto unit = hn::Set(d, static_cast<float>(MeshNode::slab_unit)), slack = hn::Set(d, ray.slab_slack);
    const auto low = hn::Sub(hn::MulSub(lanes_of(node.slab_lower + first), unit, slack), height);
    const auto high = hn::Sub(hn::MulAdd(lanes_of(node.slab_upper + first), unit, slack), height);
    // Along a slab the rate is mostly rounding. A little more moves heights by less than the slack.
    const auto inverse = hn::Div(hn::Set(d, 1.0F), hn::CopySign(hn::Max(hn::Abs(rate), hn::Set(d, 1e-4F)), rate));
    const auto to_low = hn::Mul(low, inverse), to_high = hn::Mul(high, inverse);
    in = hn::Max(in, hn::Min(to_low, to_high));
    out = hn::Min(out, hn::Max(to_low, to_high));
    hn::StoreU(in, d, enter.data() + first);
    std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, hn::Le(in, hn::Add(out, hn::Set(d, ray.place))), bits.data());
    met |= static_cast<unsigned>(bits[0]) << first;
  }
  return met;
}

// ---- Triangles of a leaf ---------------------------------------------------------

/// Bits of triangles that the ray meets within its range for certain, and of those to be looked at closely; and the
/// parameters at which it meets them.
struct LeafHits {
  unsigned certain = 0, open = 0;
  unsigned positive = 0;  ///< of those that are certain: with positive edge functions
  alignas(32) std::array<double, MeshTree::leaf_size> parameter;
};

/// SeenTriangle for the triangles of a leaf, with the same roundings. Triangles beyond `limit` are left out.
HWY_INLINE LeafHits meet_triangles(const LocalRay& ray, const LeafCorners& corners, double limit) {
  const LeafTag d;
  const std::array<std::size_t, 3> axes = {static_cast<std::size_t>(ray.axes[0]), static_cast<std::size_t>(ray.axes[1]),
                                           static_cast<std::size_t>(ray.axes[2])};
  LeafHits hits;
  for (std::size_t first = 0; first < MeshTree::leaf_size; first += hn::Lanes(d)) {
    LeafVec x[3], y[3], z[3];
    auto most = hn::Zero(d);
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = hn::Sub(corners.load(k, axes[0], first), hn::Set(d, ray.origin[ray.axes[0]]));
      y[k] = hn::Sub(hn::Sub(corners.load(k, axes[1], first), hn::Set(d, ray.origin[ray.axes[1]])),
                     hn::Mul(hn::Set(d, ray.shear[0]), x[k]));
      z[k] = hn::Sub(hn::Sub(corners.load(k, axes[2], first), hn::Set(d, ray.origin[ray.axes[2]])),
                     hn::Mul(hn::Set(d, ray.shear[1]), x[k]));
      most = hn::Max(most, hn::Max(hn::Abs(y[k]), hn::Abs(z[k])));
    }
    const auto w0 = hn::Sub(hn::Mul(y[1], z[2]), hn::Mul(z[1], y[2]));
    const auto w1 = hn::Sub(hn::Mul(y[2], z[0]), hn::Mul(z[2], y[0]));
    const auto w2 = hn::Sub(hn::Mul(y[0], z[1]), hn::Mul(z[0], y[1]));
    const auto tolerance = hn::Mul(hn::Set(d, 6 * ray.error), hn::Add(most, hn::Set(d, ray.error)));
    const auto least = hn::Min(w0, hn::Min(w1, w2)), largest = hn::Max(w0, hn::Max(w1, w2));
    const auto missed = hn::And(hn::Gt(largest, tolerance), hn::Lt(least, hn::Neg(tolerance)));
    if (hn::AllTrue(d, missed)) continue;
    const auto determinant = hn::Add(hn::Add(w0, w1), w2);
    const auto extent = hn::Sub(hn::Max(x[0], hn::Max(x[1], x[2])), hn::Min(x[0], hn::Min(x[1], x[2])));
    const auto four = hn::Mul(hn::Set(d, 4), tolerance), seen = hn::Abs(determinant);
    const auto steep = hn::And(hn::Gt(seen, four), hn::Le(hn::Mul(four, extent), hn::Mul(seen, hn::Set(d, ray.along))));
    const auto parameter = hn::Mul(
        hn::Add(x[0],
                hn::Div(hn::Add(hn::Mul(w1, hn::Sub(x[1], x[0])), hn::Mul(w2, hn::Sub(x[2], x[0]))), determinant)),
        hn::Set(d, ray.per_axis));
    const auto margin = hn::Set(d, ray.certain);
    const auto low = hn::Set(d, ray.low), high = hn::Set(d, ray.high);
    auto out = hn::Or(hn::Lt(parameter, hn::Sub(low, margin)),
                      hn::Gt(parameter, hn::Add(hn::Min(high, hn::Set(d, limit)), hn::Add(margin, margin))));
    if (ray.ignore_back_faces) {
      const auto behind = hn::Mul(determinant, hn::Set(d, std::copysign(1.0, ray.per_axis)));
      out = hn::Or(out, hn::Gt(behind, hn::Mul(hn::Set(d, 3), tolerance)));
    }
    const auto gone = hn::Or(missed, hn::And(steep, out));
    const auto inside = hn::Or(hn::Gt(least, tolerance), hn::Lt(largest, hn::Neg(tolerance)));
    const auto within = hn::And(hn::Gt(parameter, hn::Add(low, margin)), hn::Lt(parameter, hn::Sub(high, margin)));
    const auto certain = hn::AndNot(gone, hn::And(hn::And(inside, steep), within));
    hn::StoreU(parameter, d, hits.parameter.data() + first);
    std::array<std::uint8_t, 8> bits{}, left{}, sign{};
    hn::StoreMaskBits(d, certain, bits.data());
    hn::StoreMaskBits(d, hn::Gt(determinant, hn::Zero(d)), sign.data());
    hits.positive |= static_cast<unsigned>(sign[0]) << first;
    hn::StoreMaskBits(d, hn::Or(gone, certain), left.data());
    hits.certain |= static_cast<unsigned>(bits[0]) << first;
    hits.open |= (~static_cast<unsigned>(left[0]) & ((1U << hn::Lanes(d)) - 1)) << first;
  }
  return hits;
}

/// Calls sink.take() for triangles that the ray meets or may meet, nodes in front first, until it returns false. What
/// is beyond sink.limit() may be left out.
template <class Sink>
bool search(const Surface& surface, const LocalRay& ray, Sink& sink) {
  const MeshTreeView& tree = surface.tree;
  const GridRay grid_ray(ray, tree.grid);
  struct Entry {
    float enter;
    std::uint32_t link;
  };
  std::array<Entry, traversal_stack_size> stack;
  std::size_t size = 0;
  stack[size++] = {grid_ray.low, 0};
  float limit = std::min(grid_ray.high, grid_ray.limit(sink.limit()));
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.enter > limit) continue;
    const int count = MeshNode::count_of(entry.link);
    const auto child = static_cast<std::size_t>(MeshNode::child_of(entry.link));
    if (count == MeshNode::inner) {
      const MeshNode& node = tree.nodes[child];
      std::array<float, MeshNode::width> enter;
      unsigned met = meet_boxes(grid_ray, node, limit, enter);
      const std::size_t bottom = size;
      for (; met != 0; met &= met - 1) {
        const auto lane = static_cast<std::size_t>(__builtin_ctz(met));
        if (node.link[lane] >= MeshNode::unused_link) break;
        // The nearest one last, to be opened first.
        std::size_t place = size++;
        for (; place > bottom && stack[place - 1].enter < enter[lane]; --place) stack[place] = stack[place - 1];
        stack[place] = {enter[lane], node.link[lane]};
      }
      continue;
    }
    auto leaf = tree.leaves.subspan(child, static_cast<std::size_t>(count));
    while (!leaf.empty()) {
      const auto four = leaf.first(std::min<std::size_t>(leaf.size(), MeshTree::leaf_size));
      leaf = leaf.subspan(four.size());
      const LeafHits hits = meet_triangles(ray, LeafCorners(surface.mesh, four), sink.limit());
      const unsigned used = (1U << four.size()) - 1;
      for (unsigned left = (hits.certain | hits.open) & used; left != 0; left &= left - 1) {
        const auto i = static_cast<std::size_t>(__builtin_ctz(left));
        if (!sink.take(four[i], hits, i)) return false;
      }
      limit = std::min(grid_ray.high, grid_ray.limit(sink.limit()));
    }
  }
  return true;
}

TriangleD corners_of(const Surface& surface, const LeafTriangle& triangle) {
  const auto& v = triangle.vertices;
  return {surface.vertex(v[0]), surface.vertex(v[1]), surface.vertex(v[2])};
}

/// Calls self().add() for hits.
template <class Self>
struct HitSink {
  const Surface& surface;
  const LocalRay& ray;

  bool take(const LeafTriangle& triangle, const LeafHits& hits, std::size_t i) {
    double parameter = hits.parameter[i];
    if ((hits.open >> i & 1) != 0) {
      const std::optional<double> at = look_closely(ray, corners_of(surface, triangle));
      if (!at) return true;
      parameter = *at;
    }
    return static_cast<Self&>(*this).add({ray.t(parameter), parameter, triangle.triangle});
  }
};

struct First : HitSink<First> {
  FoundHit found;

  double limit() const { return found.parameter; }
  bool add(const FoundHit& hit) {
    if (hit.before(found)) found = hit;
    return true;
  }
};

struct Every : HitSink<Every> {
  bool (*visit)(void* context, const FoundHit& hit);
  void* context;

  static double limit() { return infinity; }
  bool add(const FoundHit& hit) const { return visit(context, hit); }
};

/// Counts crossings.
struct Winding {
  const Surface& surface;
  const WindingRay& ray;
  const Eigen::Vector3d& point;
  int sum = 0;

  static double limit() { return infinity; }
  bool take(const LeafTriangle& triangle, const LeafHits& hits, std::size_t i) {
    if ((hits.certain >> i & 1) != 0) {
      sum += (hits.positive >> i & 1) != 0 ? 1 : -1;
      return true;
    }
    const std::optional<int> sign = crossing(ray, corners_of(surface, triangle), point);
    sum += sign.value_or(0);
    return sign.has_value();
  }
};

}  // namespace

bool find_first_hit(const Surface& surface, const LocalRay& ray, FoundHit& found) {
  First first{{surface, ray}, found};
  search(surface, ray, first);
  if (!first.found.before(found)) return false;
  found = first.found;
  return true;
}

bool find_every_hit(const Surface& surface, const LocalRay& ray, bool (*visit)(void* context, const FoundHit& hit),
                    void* context) {
  Every every{{surface, ray}, visit, context};
  return search(surface, ray, every);
}

std::optional<int> count_crossings(const Surface& surface, const WindingRay& ray, const Eigen::Vector3d& point) {
  Winding winding{surface, ray, point};
  if (!search(surface, local_ray(surface, ray, point), winding)) return std::nullopt;
  return winding.sum;
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {

HWY_EXPORT(find_first_hit);
HWY_EXPORT(find_every_hit);
HWY_EXPORT(count_crossings);

bool first_hit(const Surface& surface, const LocalRay& ray, FoundHit& found) noexcept {
  return HWY_DYNAMIC_DISPATCH(find_first_hit)(surface, ray, found);
}

bool every_hit(const Surface& surface, const LocalRay& ray, bool (*visit)(void* context, const FoundHit& hit),
               void* context) {
  return HWY_DYNAMIC_DISPATCH(find_every_hit)(surface, ray, visit, context);
}

std::optional<int> winding_number(const Surface& surface, const WindingRay& ray,
                                  const Eigen::Vector3d& point) noexcept {
  return HWY_DYNAMIC_DISPATCH(count_crossings)(surface, ray, point);
}

}  // namespace encage
#endif
