// SPDX-License-Identifier: Apache-2.0
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "broadphase/contact/contact_leaf.cpp"
#include <hwy/foreach_target.h>  // compiles the following once for every instruction set

#include "broadphase/contact/contact_leaf.h"

#include <Eigen/Geometry>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace encage::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

namespace {

using Lanes = hn::CappedTag<double, ContactLeaf::width>;
using Vec = hn::Vec<Lanes>;

struct Vec3 {
  Vec x, y, z;
};

HWY_INLINE Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vec dot(const Vec3& a, const Vec3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Vec3 cross(const Vec3& a, const Vec3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec3 load(const ContactLeaf::Vectors& v, std::size_t first) {
  const Lanes d;
  return {hn::Load(d, v[0].data() + first), hn::Load(d, v[1].data() + first), hn::Load(d, v[2].data() + first)};
}
HWY_INLINE Vec3 repeat(const Eigen::Vector3d& v) {
  const Lanes d;
  return {hn::Set(d, v[0]), hn::Set(d, v[1]), hn::Set(d, v[2])};
}

/// Squared distances from a point to triangles: to the plane where the point lies above the triangle, else to an edge.
HWY_INLINE Vec squared_distances(const ContactLeaf& leaf, std::size_t first, const Vec3& p) {
  const Lanes d;
  const auto zero = hn::Zero(d), one = hn::Set(d, 1);
  auto above = hn::FirstN(d, ContactLeaf::width);
  auto least = hn::Set(d, std::numeric_limits<double>::infinity());
  auto height = zero;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 from = p - load(leaf.corner[k], first), along = load(leaf.edge[k], first);
    if (k == 0) height = dot(from, load(leaf.normal, first));
    above = hn::And(above, hn::Gt(dot(from, load(leaf.inward[k], first)), zero));
    const auto s = hn::Min(hn::Max(hn::Mul(dot(from, along), hn::Load(d, leaf.weight[k].data() + first)), zero), one);
    const Vec3 rest = from - Vec3{hn::Mul(s, along.x), hn::Mul(s, along.y), hn::Mul(s, along.z)};
    least = hn::Min(least, dot(rest, rest));
  }
  return hn::IfThenElse(above, hn::Mul(height, height), least);
}

void note(const ContactLeaf& leaf, std::span<ContactVertex> vertices, double reach) {
  const Lanes d;
  for (ContactVertex& v : vertices) {
    const Eigen::Vector3d beside = (leaf.lower - v.position).cwiseMax(v.position - leaf.upper).cwiseMax(0);
    if (beside.squaredNorm() > std::min(std::max(v.any, v.facing), reach * reach)) continue;
    const Vec3 p = repeat(v.position), n = repeat(v.normal);
    for (std::size_t first = 0; first < static_cast<std::size_t>(ContactLeaf::width); first += hn::Lanes(d)) {
      const auto squared = squared_distances(leaf, first, p);
      const auto cosine = hn::Add(dot(n, load(leaf.normal, first)), hn::Load(d, leaf.bias.data() + first));
      const auto facing = hn::Lt(cosine, hn::Set(d, v.most_cosine));
      const auto nearer =
          hn::Or(hn::Lt(squared, hn::Set(d, v.any)), hn::And(facing, hn::Lt(squared, hn::Set(d, v.facing))));
      if (hn::AllFalse(d, nearer)) continue;
      alignas(32) std::array<double, ContactLeaf::width> value;
      std::uint8_t bits[8] = {};
      hn::Store(squared, d, value.data());
      hn::StoreMaskBits(d, facing, bits);
      for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
        const std::int32_t triangle = leaf.triangle[first + lane];
        if (value[lane] < v.any) {
          v.any = value[lane];
          v.any_triangle = triangle;
        }
        if ((bits[0] >> lane & 1U) != 0 && value[lane] < v.facing) {
          v.facing = value[lane];
          v.facing_triangle = triangle;
        }
      }
    }
  }
}

HWY_INLINE Vec least(const Vec& a, const Vec& b, const Vec& c) { return hn::Min(hn::Min(a, b), c); }
HWY_INLINE Vec most(const Vec& a, const Vec& b, const Vec& c) { return hn::Max(hn::Max(a, b), c); }

std::uint32_t touching(const ContactLeaf& a, std::size_t lane, const ContactLeaf& b, double slack) {
  const Lanes d;
  const auto gap = hn::Set(d, slack), under = hn::Set(d, -slack);
  const auto corner = [&](std::size_t k) {
    return Eigen::Vector3d(a.corner[k][0][lane], a.corner[k][1][lane], a.corner[k][2][lane]);
  };
  const Eigen::Vector3d own[3] = {corner(0), corner(1), corner(2)};
  const Eigen::Vector3d low = own[0].cwiseMin(own[1]).cwiseMin(own[2]), high = own[0].cwiseMax(own[1]).cwiseMax(own[2]);
  const Eigen::Vector3d normal(a.normal[0][lane], a.normal[1][lane], a.normal[2][lane]);
  const auto height = hn::Set(d, normal.dot(own[0]));
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < static_cast<std::size_t>(ContactLeaf::width); first += hn::Lanes(d)) {
    const Vec3 p = load(b.corner[0], first), q = load(b.corner[1], first), r = load(b.corner[2], first);
    auto apart = hn::Not(hn::FirstN(d, ContactLeaf::width));
    const auto beside = [&](const Vec& u, const Vec& v, const Vec& w, double lower, double upper) HWY_ATTR {
      return hn::Or(hn::Gt(hn::Sub(least(u, v, w), hn::Set(d, upper)), gap),
                    hn::Lt(hn::Sub(most(u, v, w), hn::Set(d, lower)), under));
    };
    apart = hn::Or(apart, beside(p.x, q.x, r.x, low[0], high[0]));
    apart = hn::Or(apart, beside(p.y, q.y, r.y, low[1], high[1]));
    apart = hn::Or(apart, beside(p.z, q.z, r.z, low[2], high[2]));
    if (hn::AllTrue(d, apart)) continue;
    const Vec3 n = repeat(normal);
    const auto hp = hn::Sub(dot(n, p), height), hq = hn::Sub(dot(n, q), height), hr = hn::Sub(dot(n, r), height);
    apart = hn::Or(apart, hn::Or(hn::Gt(least(hp, hq, hr), gap), hn::Lt(most(hp, hq, hr), under)));
    const Vec3 m = load(b.normal, first);
    const auto hu = dot(m, repeat(own[0]) - p), hv = dot(m, repeat(own[1]) - p), hw = dot(m, repeat(own[2]) - p);
    apart = hn::Or(apart, hn::Or(hn::Gt(least(hu, hv, hw), gap), hn::Lt(most(hu, hv, hw), under)));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Not(apart), bits);
    result |= static_cast<std::uint32_t>(bits[0]) << first;
  }
  return result & ((1U << b.count) - 1);
}

}  // namespace

std::uint32_t edges_may_meet(const ContactEdges& a, int lane, const ContactEdges& b, double slack) {
  const Lanes d;
  const auto at = static_cast<std::size_t>(lane);
  const Vec3 u = repeat({a.along[0][at], a.along[1][at], a.along[2][at]});
  const auto slack_a = hn::Set(d, slack * a.length[at]);
  std::uint32_t result = 0;
  for (std::size_t first = 0; first < static_cast<std::size_t>(ContactEdges::width); first += hn::Lanes(d)) {
    const Vec3 n = cross(u, load(b.along, first));
    const auto gap = hn::Mul(slack_a, hn::LoadU(d, b.length.data() + first));
    const auto p = dot(n, load(b.out[0], first)), q = dot(n, load(b.out[1], first));
    const auto meet =
        hn::And(hn::Gt(gap, hn::Zero(d)), hn::Or(hn::Ge(hn::Min(p, q), hn::Neg(gap)), hn::Le(hn::Max(p, q), gap)));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, meet, bits);
    result |= static_cast<std::uint32_t>(bits[0]) << first;
  }
  return result;
}

std::uint32_t may_touch(const ContactLeaf& a, int lane, const ContactLeaf& b, double slack) {
  return touching(a, static_cast<std::size_t>(lane), b, slack);
}

void note_nearest(const ContactLeaf& leaf, std::span<ContactVertex> vertices, double reach) {
  note(leaf, vertices, reach);
}

}  // namespace encage::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace encage {

void ContactLeaf::set(int lane, std::int32_t number, const std::array<Eigen::Vector3d, 3>& corners,
                      const Eigen::Vector3d& n) {
  const auto at = static_cast<std::size_t>(lane);
  const auto store = [&](Vectors& out, const Eigen::Vector3d& v) {
    for (std::size_t i = 0; i < 3; ++i) out[i][at] = v[static_cast<Eigen::Index>(i)];
  };
  for (const Eigen::Vector3d& c : corners) {
    lower = lower.cwiseMin(c);
    upper = upper.cwiseMax(c);
  }
  store(normal, n);
  bias[at] = n.isZero(0) ? -2 : 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d along = corners[(k + 1) % 3] - corners[k];
    const double squared = along.squaredNorm();
    store(corner[k], corners[k]);
    store(edge[k], along);
    store(inward[k], n.cross(along));
    weight[k][at] = squared > 0 ? 1 / squared : 0;
  }
  triangle[at] = number;
}

HWY_EXPORT(edges_may_meet);
HWY_EXPORT(may_touch);
HWY_EXPORT(note_nearest);

std::uint32_t edges_may_meet(const ContactEdges& a, int lane, const ContactEdges& b, double slack) {
  return HWY_DYNAMIC_DISPATCH(edges_may_meet)(a, lane, b, slack);
}

std::uint32_t may_touch(const ContactLeaf& a, int lane, const ContactLeaf& b, double slack) {
  return HWY_DYNAMIC_DISPATCH(may_touch)(a, lane, b, slack);
}

void note_nearest(const ContactLeaf& leaf, std::span<ContactVertex> vertices, double reach) {
  HWY_DYNAMIC_DISPATCH(note_nearest)(leaf, vertices, reach);
}

}  // namespace encage
#endif
