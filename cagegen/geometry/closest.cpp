// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/closest.h"

#include <algorithm>
#include <limits>

namespace encage::makers {

namespace {

Point at(const Corners& c, const std::array<double, 3>& w) { return w[0] * c[0] + w[1] * c[1] + w[2] * c[2]; }

double clamp01(double x) { return std::min(std::max(x, 0.0), 1.0); }

/// Parameters of the closest points of the segments p + s d and q + t e (Lumelsky 1985).
void closest_on_segments(const Point& p, const Point& d, const Point& q, const Point& e, double& s, double& t) {
  const Point r = q - p;
  const double dd = d.dot(d);
  const double ee = e.dot(e);
  const double de = d.dot(e);
  const double dr = d.dot(r);
  const double er = e.dot(r);
  const double determinant = dd * ee - de * de;
  s = determinant > 1e-14 * dd * ee ? clamp01((dr * ee - er * de) / determinant) : 0;
  t = ee > 0 ? clamp01((s * de - er) / ee) : 0;
  s = dd > 0 ? clamp01((t * de + dr) / dd) : 0;
}

/// Weights of the foot of x on the plane of the triangle; false if it falls outside.
bool foot_inside(const Point& x, const Corners& c, std::array<double, 3>& weight) {
  const Point u = c[1] - c[0];
  const Point v = c[2] - c[0];
  const Point n = u.cross(v);
  const double n2 = n.squaredNorm();
  if (n2 == 0) return false;
  const Point w = x - c[0];
  const double b = w.cross(v).dot(n) / n2;
  const double g = u.cross(w).dot(n) / n2;
  if (b < 0 || g < 0 || b + g > 1) return false;
  weight = {1 - b - g, b, g};
  return true;
}

}  // namespace

ClosestPair closest_points(const Corners& s, const Corners& t) {
  ClosestPair best;
  best.distance2 = std::numeric_limits<double>::infinity();
  const auto offer = [&](const std::array<double, 3>& ws, const std::array<double, 3>& wt) {
    const double distance2 = (at(s, ws) - at(t, wt)).squaredNorm();
    if (distance2 < best.distance2) best = {distance2, ws, wt};
  };
  for (int i = 0; i < 3; ++i) {
    std::array<double, 3> corner{};
    corner[i] = 1;
    std::array<double, 3> foot;
    if (foot_inside(s[i], t, foot)) offer(corner, foot);
    if (foot_inside(t[i], s, foot)) offer(foot, corner);
    for (int j = 0; j < 3; ++j) {
      double a = 0;
      double b = 0;
      closest_on_segments(s[i], s[(i + 1) % 3] - s[i], t[j], t[(j + 1) % 3] - t[j], a, b);
      std::array<double, 3> ws{};
      std::array<double, 3> wt{};
      ws[i] = 1 - a;
      ws[(i + 1) % 3] = a;
      wt[j] = 1 - b;
      wt[(j + 1) % 3] = b;
      offer(ws, wt);
    }
  }
  return best;
}

}  // namespace encage::makers
