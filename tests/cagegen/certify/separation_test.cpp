// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/separation.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

namespace encage::proof {
namespace {

/// Ordinary triangles, slivers, segments and points, of many sizes.
Corners random_triangle(shapes::Random& random) {
  const double size = std::ldexp(1.0, -random.integer(20));
  const Point base = random.point(1);
  Corners t = {base, base + random.point(size), base + random.point(size)};
  switch (random.integer(5)) {
    case 0: t[2] = t[1] + random.point(size * 1e-9); break;
    case 1: t[2] = 0.5 * (t[0] + t[1]); break;
    case 2: t[1] = t[2] = t[0]; break;
    default: break;
  }
  return t;
}

TEST(Separation, LowerBoundNeverExceedsTheDistance) {
  shapes::Random random(1);
  int proven = 0;
  for (int i = 0; i < 4000; ++i) {
    const Corners a = random_triangle(random);
    Corners b = random_triangle(random);
    // Half of them close together: move b so that a corner almost meets a point of a.
    if (i % 2 == 0) {
      const Point goal = (a[0] + a[1] + a[2]) / 3 + random.point(std::ldexp(1.0, -random.integer(45)));
      const Point by = goal - b[0];
      for (Point& corner : b) corner += by;
    }
    const Separation s = separate(a, b);
    if (s.lower == 0) continue;
    ++proven;
    const double distance = exact_distance(a, b);
    ASSERT_LE(s.lower, distance * (1 + 4e-15)) << i;
    ASSERT_GE(s.upper, distance * (1 - 1e-6) - 1e-15) << i;
  }
  EXPECT_GT(proven, 2500);
}

TEST(Separation, IsTightForTrianglesApart) {
  shapes::Random random(2);
  int tight = 0;
  for (int i = 0; i < 2000; ++i) {
    const Corners a = random_triangle(random);
    const Corners b = random_triangle(random);
    const Separation s = separate(a, b);
    if (s.lower >= s.upper * (1 - 1e-9)) ++tight;
  }
  EXPECT_GT(tight, 1900);
}

TEST(Separation, NothingIsProvenOfTouchingTriangles) {
  const Corners a = {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)};
  EXPECT_EQ(separate(a, {Point(0.2, 0.2, 0), Point(0, 0, 1), Point(1, 1, 1)}).lower, 0);
  EXPECT_EQ(separate(a, {Point(0.5, -1, -1), Point(0.5, 1, 1), Point(0.5, -1, 1)}).lower, 0);
  EXPECT_EQ(separate(a, a).lower, 0);
  EXPECT_EQ(gap_along(Point::Zero(), a, {Point(5, 5, 5), Point(6, 5, 5), Point(5, 6, 5)}), 0);
}

}  // namespace
}  // namespace encage::proof
