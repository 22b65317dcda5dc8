// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/twins/delicate.h"

#include <cmath>

namespace encage::twins {

using test::TwinRandom;
using Vector = Eigen::Vector3d;

TriangleD random_triangle(TwinRandom& random) {
  TriangleD t{random.point(1), random.point(1), random.point(1)};
  const double u = random.uniform(-0.5, 1.5);
  switch (random.below(12)) {
    case 0: t[2] = t[0] + u * (t[1] - t[0]) + random.point(std::pow(10.0, -random.uniform(2, 17))); break;  // a sliver
    case 1: t[1] = t[0] + random.point(std::pow(10.0, -random.uniform(2, 17))); break;  // one tiny edge
    case 2: t[2] = t[0] + u * (t[1] - t[0]); break;                                     // nearly collinear
    case 3: t[2] = t[1]; break;
    case 4: t[1] = t[2] = t[0]; break;
    case 5:
      for (Vector& v : t) v = t[0] + 1e-8 * (v - t[0]);
      break;
    case 6:
    case 7:
      for (Vector& v : t) v = (3 * v).array().round();
      break;
    default: break;
  }
  return t;
}

Vector point_of(TwinRandom& random, const TriangleD& t) {
  const unsigned kind = random.below(3), k = random.below(3);
  if (kind == 0) return t[k];
  const double u = random.coin() ? 0.5 : random.uniform(0, 1), v = kind == 1 ? 0 : random.uniform(0, 1 - u);
  return (1 - u - v) * t[k] + u * t[(k + 1) % 3] + v * t[(k + 2) % 3];
}

Vector random_gap(TwinRandom& random, const TriangleD& a, const TriangleD& b) {
  if (random.below(3) == 0) return Vector::Zero();
  const double gap = std::pow(10.0, -random.uniform(2, 16));
  const auto edge = [&](const TriangleD& t) -> Vector {
    const unsigned k = random.below(3);
    return t[(k + 1) % 3] - t[k];
  };
  // A direction that is a normal of closest features, or a random one.
  Vector d = random.direction();
  if (random.below(3) != 0) d = edge(a).cross(random.coin() ? edge(a) : edge(b));
  return d.norm() > 1e-12 ? (gap / d.norm() * d).eval() : Vector::Zero();
}

double nudged(TwinRandom& random, double x) {
  const double towards = random.coin() ? 1e300 : 0;
  for (unsigned i = random.below(3); i > 0; --i) x = std::nextafter(x, towards);
  return random.below(4) == 0 ? x * random.uniform(0.9, 1.1) : x;
}

Setting Setting::any(TwinRandom& random) {
  Setting setting;
  switch (random.below(8)) {
    case 0: setting.offset = random.point(1e6); break;
    case 1: setting.scale = std::pow(10.0, random.uniform(-30, 30)); break;
    case 2:
      setting.scale = random.coin() ? 1e30 : 1e-30;
      setting.offset = random.point(1) * setting.scale;
      break;
    default: break;
  }
  return setting;
}

TrianglePairSample random_triangle_pair(TwinRandom& random) {
  TriangleD a = random_triangle(random), b = random_triangle(random);
  if (random.below(4) != 0) {
    const Vector by = point_of(random, a) - point_of(random, b) + random_gap(random, a, b);
    for (Vector& v : b) v += by;
  }
  const Setting setting = Setting::any(random);
  setting.apply(a);
  setting.apply(b);
  return {a, b, setting};
}

}  // namespace encage::twins
