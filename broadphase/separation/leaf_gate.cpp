// SPDX-License-Identifier: Apache-2.0
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/separation/leaf_gate.cpp"
#include <hwy/foreach_target.h>  // compiles the following once for every instruction set

#include "broadphase/separation/leaf_gate.h"
#include "src/limits.h"

#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

namespace {

using Lanes = hn::CappedTag<double, LeafLanes::width>;
using Vec = hn::Vec<Lanes>;
using Mask = hn::Mask<Lanes>;

struct Vec3 {
  Vec x, y, z;
};

HWY_INLINE Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec dot(const Vec3& a, const Vec3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vec3 cross(const Vec3& a, const Vec3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

/// One triangle per lane.
struct Triangles {
  Vec3 corner[3];

  HWY_INLINE Vec3 sum() const { return corner[0] + corner[1] + corner[2]; }
  HWY_INLINE Vec3 edge(int k) const { return corner[(k + 1) % 3] - corner[k]; }
};

/// Loads the lanes [first, first + lanes of the machine).
HWY_INLINE Triangles load(const LeafLanes::Corners& corners, std::size_t first) {
  const Lanes d;
  Triangles t;
  for (int k = 0; k < 3; ++k) {
    t.corner[k] = {hn::LoadU(d, corners[k][0].data() + first), hn::LoadU(d, corners[k][1].data() + first),
                   hn::LoadU(d, corners[k][2].data() + first)};
  }
  return t;
}

/// Returns the same triangle in all lanes.
HWY_INLINE Triangles repeat(const LeafLanes::Corners& corners, int lane) {
  const Lanes d;
  Triangles t;
  for (int k = 0; k < 3; ++k) {
    t.corner[k] = {hn::Set(d, corners[k][0][lane]), hn::Set(d, corners[k][1][lane]), hn::Set(d, corners[k][2][lane])};
  }
  return t;
}

HWY_INLINE Vec least(const Vec& a, const Vec& b, const Vec& c) { return hn::Min(hn::Min(a, b), c); }
HWY_INLINE Vec most(const Vec& a, const Vec& b, const Vec& c) { return hn::Max(hn::Max(a, b), c); }

template <int kEnds>
struct Test {
  Triangles a[kEnds], b[kEnds];
  Vec distance;

  /// Lanes in which b stays above or below a by more than `required`. `project` maps a corner to its height.
  template <class Project>
  HWY_INLINE Mask separated(const Vec& required, Project&& project) const {
    const Lanes d;
    Mask above = hn::FirstN(d, LeafLanes::width), below = above;
    for (int end = 0; end < kEnds; ++end) {
      const Vec a0 = project(a[end].corner[0]), a1 = project(a[end].corner[1]), a2 = project(a[end].corner[2]);
      const Vec b0 = project(b[end].corner[0]), b1 = project(b[end].corner[1]), b2 = project(b[end].corner[2]);
      above = hn::And(above, hn::Gt(hn::Sub(least(b0, b1, b2), most(a0, a1, a2)), required));
      below = hn::And(below, hn::Gt(hn::Sub(least(a0, a1, a2), most(b0, b1, b2)), required));
    }
    return hn::Or(above, below);
  }

  /// Tests an axis of any length. Where underflow could have occurred in its norm or the projections, it separates
  /// nothing.
  HWY_INLINE Mask separated_along(const Vec3& n) const {
    const Lanes d;
    const Vec squared = dot(n, n), required = hn::Mul(hn::Sqrt(squared), distance);
    const Mask sound =
        hn::And(hn::Gt(squared, hn::Set(d, smallest_square)), hn::Gt(required, hn::Set(d, smallest_product)));
    return hn::And(sound, separated(required, [&](const Vec3& x) { return dot(n, x); }));
  }

  /// Returns the triangles in the middle of the interval, twice as large. An axis for the middle often separates both
  /// ends.
  static HWY_INLINE Triangles middle(const Triangles* t) {
    if (kEnds == 1) return t[0];
    Triangles m;
    for (int k = 0; k < 3; ++k) m.corner[k] = t[0].corner[k] + t[kEnds - 1].corner[k];
    return m;
  }

  HWY_INLINE Mask apart() const {
    const Lanes d;
    Mask result = separated(distance, [](const Vec3& x) { return x.x; });
    result = hn::Or(result, separated(distance, [](const Vec3& x) { return x.y; }));
    result = hn::Or(result, separated(distance, [](const Vec3& x) { return x.z; }));
    if (hn::AllTrue(d, result)) return result;
    const Triangles ma = middle(a), mb = middle(b);
    result = hn::Or(result, separated_along(mb.sum() - ma.sum()));
    result = hn::Or(result, separated_along(cross(ma.edge(0), ma.edge(1))));
    result = hn::Or(result, separated_along(cross(mb.edge(0), mb.edge(1))));
    if (kEnds == 2 || hn::AllTrue(d, result)) return result;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) result = hn::Or(result, separated_along(cross(ma.edge(i), mb.edge(j))));
    }
    return result;
  }
};

template <int kEnds>
std::uint32_t not_apart(const LeafLanes& a, int lane, const LeafLanes& b, int count, double distance) {
  const Lanes d;
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < static_cast<std::size_t>(count); first += hn::Lanes(d)) {
    Test<kEnds> test;
    for (int end = 0; end < kEnds; ++end) {
      test.a[end] = repeat(a.corners[end], lane);
      test.b[end] = load(b.corners[end], first);
    }
    test.distance = hn::Set(d, distance);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Not(test.apart()), bits);
    result |= static_cast<std::uint32_t>(bits[0]) << first;
  }
  return result & ((1U << count) - 1);
}

}  // namespace

std::uint32_t lanes_not_apart(const LeafLanes& a, int lane, const LeafLanes& b, int count, int ends, double distance) {
  return ends == 1 ? not_apart<1>(a, lane, b, count, distance) : not_apart<2>(a, lane, b, count, distance);
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {

void LeafLanes::set(int lane, const MovingTriangle& triangle, int ends) {
  for (int end = 0; end < ends; ++end) {
    const TriangleD& t = end == 0 ? triangle.start : triangle.end;
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) corners[end][k][i][lane] = t[k][i];
    }
  }
}

MovingTriangle LeafLanes::triangle(int lane, int ends) const {
  MovingTriangle triangle;
  for (int end = 0; end < ends; ++end) {
    TriangleD& t = end == 0 ? triangle.start : triangle.end;
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) t[k][i] = corners[end][k][i][lane];
    }
  }
  return triangle;
}

HWY_EXPORT(lanes_not_apart);

std::uint32_t lanes_not_apart(const LeafLanes& a, int lane, const LeafLanes& b, int count, int ends, double distance) {
  return HWY_DYNAMIC_DISPATCH(lanes_not_apart)(a, lane, b, count, ends, distance);
}

}  // namespace encage
#endif
