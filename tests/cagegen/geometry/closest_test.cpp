// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/geometry/closest.h"

#include "cagegen/certify/separation.h"
#include "tests/cagegen/geometry/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace encage::makers {
namespace {

using shapes::Random;

Point at(const Corners& t, const std::array<double, 3>& weight) {
  return weight[0] * t[0] + weight[1] * t[1] + weight[2] * t[2];
}

/// Weights and distance belong together, and the points lie in the triangles.
double checked_distance(const Corners& s, const Corners& t) {
  const ClosestPair pair = closest_points(s, t);
  for (const auto& weight : {pair.weight_s, pair.weight_t}) {
    EXPECT_NEAR(weight[0] + weight[1] + weight[2], 1, 1e-12);
    for (const double w : weight) EXPECT_TRUE(w >= -1e-12 && w <= 1 + 1e-12) << w;
  }
  EXPECT_NEAR(std::sqrt(pair.distance2), (at(s, pair.weight_s) - at(t, pair.weight_t)).norm(), 1e-12);
  return std::sqrt(pair.distance2);
}

/// Alternating projections from many starts: an upper bound that comes down to the distance.
double sampled_distance(const Corners& s, const Corners& t, Random& random) {
  double best = 1e300;
  for (int i = 0; i < 300; ++i) {
    double a = random(0, 1), b = random(0, 1), c = random(0, 1), d = random(0, 1);
    if (a + b > 1) a = 1 - a, b = 1 - b;
    if (c + d > 1) c = 1 - c, d = 1 - d;
    best = std::min(best, (at(s, {1 - a - b, a, b}) - at(t, {1 - c - d, c, d})).norm());
  }
  return best;
}

TEST(ClosestPoints, AgreesWithTheCertificatesDistance) {
  Random random(21);
  int compared = 0;
  for (int i = 0; i < 20000; ++i) {
    Corners s = shapes::awkward_triangle(random, 1);
    Corners t = shapes::awkward_triangle(random, i % 2 ? 1 : 0.1);
    const Point shift = random.point(i % 5 ? 3 : 100);
    for (Point& p : t) p += shift;
    const proof::Separation reference = proof::separate(s, t);
    if (reference.lower < 1e-6) continue;  // disjoint triangles only
    ++compared;
    const double distance = checked_distance(s, t);
    EXPECT_GE(distance, reference.lower * (1 - 1e-9));
    EXPECT_NEAR(distance, reference.upper, 1e-7 * (1 + reference.upper)) << i;
    EXPECT_NEAR(checked_distance(t, s), distance, 1e-9 * (1 + distance)) << i;
  }
  EXPECT_GT(compared, 10000);
}

TEST(ClosestPoints, NoSampleIsCloser) {
  Random random(22);
  for (int i = 0; i < 300; ++i) {
    const Corners s = shapes::awkward_triangle(random, 1);
    Corners t = shapes::awkward_triangle(random, 1);
    for (Point& p : t) p += Point(2.5, 0, 0) + random.point(0.5);
    EXPECT_LE(checked_distance(s, t), sampled_distance(s, t, random) + 1e-12);
  }
}

TEST(ClosestPoints, KnownAnswers) {
  const Corners base{Point(0, 0, 0), Point(4, 0, 0), Point(0, 4, 0)};
  EXPECT_DOUBLE_EQ(checked_distance(base, {Point(1, 1, 2), Point(1, 1, 5), Point(2, 1, 5)}), 2);      // corner to face
  EXPECT_DOUBLE_EQ(checked_distance(base, {Point(0, 0, 3), Point(4, 0, 3), Point(0, 4, 3)}), 3);      // parallel
  EXPECT_DOUBLE_EQ(checked_distance(base, {Point(1, -2, -1), Point(1, -2, 1), Point(1, -9, 0)}), 2);  // edge to edge
  EXPECT_DOUBLE_EQ(checked_distance(base, {Point(-3, -4, 0), Point(-9, -4, 0), Point(-3, -9, 0)}), 5);  // corners
  EXPECT_DOUBLE_EQ(checked_distance(base, {Point(0, -1, 0), Point(4, -1, 0), Point(2, -3, 0)}), 1);     // coplanar
  EXPECT_DOUBLE_EQ(checked_distance(base, {Point(1, 1, 7), Point(1, 1, 7), Point(1, 1, 7)}), 7);        // a point
  EXPECT_DOUBLE_EQ(checked_distance(base, {Point(-1, 1, 1), Point(3, 1, 1), Point(1, 1, 1)}), 1);       // a segment
  const Corners point{Point(1, 2, 2), Point(1, 2, 2), Point(1, 2, 2)};
  const Corners origin{Point::Zero(), Point::Zero(), Point::Zero()};
  EXPECT_DOUBLE_EQ(checked_distance(point, origin), 3);
}

}  // namespace
}  // namespace encage::makers
