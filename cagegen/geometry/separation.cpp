// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/separation.h"

#include <algorithm>
#include <cmath>

namespace encage::makers {

namespace {

// Sines below this count as touching.
constexpr double least_sine = 1e-6;
// A dihedral fold sharper than this (cosine between the half-planes) is refused.
constexpr double sharpest_fold = 1 - 1e-9;

bool gap_along(const Point& axis, const Corners& s, const Corners& t, double clearance) {
  const double length2 = axis.squaredNorm();
  if (length2 == 0) return false;
  // Relative to a corner: the sums stay small far from the origin.
  const double s1 = axis.dot(s[1] - s[0]);
  const double s2 = axis.dot(s[2] - s[0]);
  const double t0 = axis.dot(t[0] - s[0]);
  const double t1 = axis.dot(t[1] - s[0]);
  const double t2 = axis.dot(t[2] - s[0]);
  const double gap =
      std::max(std::min({t0, t1, t2}) - std::max({0.0, s1, s2}), std::min({0.0, s1, s2}) - std::max({t0, t1, t2}));
  return gap > 0 && gap * gap > clearance * clearance * length2;
}

/// The plane through the apex with this normal: a, b on one side, c, d on the other, one pair strictly.
bool splits(const Point& normal, const Point& a, const Point& b, const Point& c, const Point& d) {
  const double length = normal.norm();
  if (length < least_sine) return false;
  const double low_ab = std::min(normal.dot(a), normal.dot(b)) / length;
  const double high_ab = std::max(normal.dot(a), normal.dot(b)) / length;
  const double low_cd = std::min(normal.dot(c), normal.dot(d)) / length;
  const double high_cd = std::max(normal.dot(c), normal.dot(d)) / length;
  constexpr double rounding = 1e-12;
  return (low_ab >= -rounding && high_cd < -least_sine) || (low_ab > least_sine && high_cd <= rounding) ||
         (low_cd >= -rounding && high_ab < -least_sine) || (low_cd > least_sine && high_ab <= rounding);
}

/// The plane through the apex, along a and c: b and d strictly on opposite sides.
bool splits_along(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point normal = a.cross(c);
  const double length = normal.norm();
  if (length < least_sine) return false;
  const double side_b = normal.dot(b) / length;
  const double side_d = normal.dot(d) / length;
  return (side_b > least_sine && side_d < -least_sine) || (side_b < -least_sine && side_d > least_sine);
}

/// a and c point in opposite directions, as in a grid: some plane along them has b and d far on opposite sides.
bool splits_across(const Point& a, const Point& b, const Point& c, const Point& d) {
  constexpr double far = 1e-3;
  if (a.dot(c) > 0 || a.cross(c).norm() >= least_sine) return false;
  const Point e = (a - c).normalized();
  const Point normal = ((b - e.dot(b) * e).normalized() - (d - e.dot(d) * e).normalized()) / 2;
  return normal.dot(b) > far && normal.dot(d) < -far;
}

}  // namespace

bool separated(const Corners& s, const Corners& t, double clearance) {
  const std::array<Point, 3> es{s[1] - s[0], s[2] - s[1], s[0] - s[2]};
  const std::array<Point, 3> et{t[1] - t[0], t[2] - t[1], t[0] - t[2]};
  const Point ns = es[0].cross(es[1]);
  if (gap_along(ns, s, t, clearance)) return true;
  const Point nt = et[0].cross(et[1]);
  if (gap_along(nt, s, t, clearance)) return true;
  for (const Point& e : es) {
    for (const Point& f : et) {
      if (gap_along(e.cross(f), s, t, clearance)) return true;
    }
  }
  for (int i = 0; i < 3; ++i) {
    if (gap_along(ns.cross(es[i]), s, t, clearance)) return true;
    if (gap_along(nt.cross(et[i]), s, t, clearance)) return true;
    // Collinear or vanishing triangles have no normal: the edges themselves separate then.
    if (gap_along(et[i], s, t, clearance)) return true;
  }
  return false;
}

bool separated_at_corner(const Point& apex, const Point& pa, const Point& pb, const Point& pc, const Point& pd) {
  const Point a = (pa - apex).normalized();
  const Point b = (pb - apex).normalized();
  const Point c = (pc - apex).normalized();
  const Point d = (pd - apex).normalized();
  const Point n = a.cross(b);
  const Point m = c.cross(d);
  return splits(n, a, b, c, d) || splits(m, a, b, c, d) || splits_along(a, b, c, d) || splits_along(a, b, d, c) ||
         splits_along(b, a, c, d) || splits_along(b, a, d, c) || splits(n.cross(a), a, b, c, d) ||
         splits(n.cross(b), a, b, c, d) || splits(m.cross(c), a, b, c, d) || splits(m.cross(d), a, b, c, d) ||
         splits_across(a, b, c, d) || splits_across(a, b, d, c) || splits_across(b, a, c, d) ||
         splits_across(b, a, d, c);
}

bool separated_at_edge(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Point e = (b - a).normalized();
  const Point w = (c - a) - e.dot(c - a) * e;
  const Point x = (d - a) - e.dot(d - a) * e;
  return w.dot(x) < sharpest_fold * w.norm() * x.norm();
}

bool separated(const std::array<std::int32_t, 3>& index_s, const Corners& s, const std::array<std::int32_t, 3>& index_t,
               const Corners& t, double clearance) {
  int shared = 0;
  int in_s = 0;  // sums of the shared corners: one index, or three less the third one
  int in_t = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (index_s[i] != index_t[j]) continue;
      ++shared;
      in_s += i;
      in_t += j;
    }
  }
  switch (shared) {
    case 0: return separated(s, t, clearance);
    case 1:
      return separated_at_corner(s[in_s], s[(in_s + 1) % 3], s[(in_s + 2) % 3], t[(in_t + 1) % 3], t[(in_t + 2) % 3]);
    case 2: {
      const int apex = 3 - in_s;
      return separated_at_edge(s[(apex + 1) % 3], s[(apex + 2) % 3], s[apex], t[3 - in_t]);
    }
    default: return false;
  }
}

double solid_angle(const Point& x, const Corners& t) {
  // Van Oosterom and Strackee 1983.
  const Point a = (t[0] - x).normalized();
  const Point b = (t[1] - x).normalized();
  const Point c = (t[2] - x).normalized();
  return 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
}

bool common_direction(std::span<const Point> normals) {
  constexpr double least = 0.02;
  Point direction = Point::Zero();
  for (const Point& n : normals) direction += n;
  for (int step = 0; step < 24; ++step) {
    direction.normalize();
    double worst = 1;
    std::size_t index = 0;
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const double d = direction.dot(normals[i]);
      if (d < worst) {
        worst = d;
        index = i;
      }
    }
    if (worst > least) return true;
    direction += (0.2 - worst) * normals[index];
  }
  return false;
}

}  // namespace encage::makers
