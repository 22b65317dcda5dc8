// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/exact.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace encage::proof {
namespace {

const Corners unit = {Point(0, 0, 0), Point(1, 0, 0), Point(0, 1, 0)};

double next_up(double x) { return std::nextafter(x, std::numeric_limits<double>::infinity()); }

TEST(Exact, Degenerate) {
  EXPECT_FALSE(degenerate(unit));
  EXPECT_TRUE(degenerate({Point(0, 0, 0), Point(1, 1, 1), Point(3, 3, 3)}));
  EXPECT_TRUE(degenerate({Point(1, 2, 3), Point(1, 2, 3), Point(4, 5, 6)}));
  EXPECT_FALSE(degenerate({Point(0, 0, 0), Point(1, 1, 1), Point(3, 3, next_up(3))}));
}

TEST(Exact, TouchIsClosed) {
  EXPECT_TRUE(touch(unit, {Point(0.25, 0.25, 0), Point(1, 1, 1), Point(0, 1, 1)})) << "vertex on face";
  EXPECT_TRUE(touch(unit, {Point(1, 0, 0), Point(2, 0, 0), Point(2, 0, 1)})) << "vertex on vertex";
  EXPECT_TRUE(touch(unit, {Point(0.5, -1, -1), Point(0.5, 1, 1), Point(0.5, -1, 1)})) << "edge through edge";
  EXPECT_TRUE(touch(unit, {Point(0.1, 0.1, 0), Point(0.2, 0.1, 0), Point(0.1, 0.2, 0)})) << "coplanar inside";
  EXPECT_FALSE(touch(unit, {Point(0.25, 0.25, 5e-324), Point(1, 1, 1), Point(0, 1, 1)}));
  EXPECT_FALSE(touch(unit, {Point(next_up(0.5), 0.5, 0), Point(1, 1, 0), Point(1, 0.5, 0)})) << "coplanar, apart";
}

TEST(Exact, DegenerateTrianglesAreSegmentsAndPoints) {
  EXPECT_TRUE(touch(unit, {Point(0.25, 0.25, 0), Point(0.25, 0.25, 0), Point(0.25, 0.25, 0)}));
  EXPECT_FALSE(touch(unit, {Point(0.75, 0.75, 0), Point(0.75, 0.75, 0), Point(0.75, 0.75, 0)}));
  // The middle corner comes first, and last: the segment is spanned by the outer two.
  EXPECT_TRUE(touch(unit, {Point(0.25, 0.25, 1), Point(0.25, 0.25, 2), Point(0.25, 0.25, -1)}));
  EXPECT_TRUE(touch(unit, {Point(0.25, 0.25, -1), Point(0.25, 0.25, 2), Point(0.25, 0.25, 2)}));
  EXPECT_FALSE(touch(unit, {Point(0.25, 0.25, 1), Point(0.25, 0.25, 2), Point(0.25, 0.25, 3)}));
  EXPECT_TRUE(touch(unit, {Point(-1, 0.5, 0), Point(0, 0.5, 0), Point(3, 0.5, 0)})) << "coplanar segment";
}

TEST(Exact, OverlapAtVertex) {
  const Point v(0, 0, 0), a(1, 0, 0), b(0, 1, 0);
  EXPECT_FALSE(overlap_at_vertex(v, a, b, Point(1, 0, 1), Point(0, 1, 1)));
  EXPECT_FALSE(overlap_at_vertex(v, a, b, Point(-1, 0, 0), Point(0, -1, 0))) << "coplanar, opposite wedges";
  EXPECT_TRUE(overlap_at_vertex(v, a, b, Point(1, 1, 0), Point(-1, 0, 0))) << "coplanar, one ray inside";
  EXPECT_TRUE(overlap_at_vertex(v, a, b, Point(1, -1, 0), Point(1, 2, 0))) << "coplanar, around";
  EXPECT_TRUE(overlap_at_vertex(v, a, b, Point(2, 0, 0), Point(1, -1, 0))) << "coplanar, along an edge";
  EXPECT_TRUE(overlap_at_vertex(v, a, b, Point(1, 1, -1), Point(1, 1, 1))) << "through the middle";
  EXPECT_FALSE(overlap_at_vertex(v, a, b, Point(1, -1, -1), Point(1, -1, 1))) << "crosses the plane outside";
  EXPECT_TRUE(overlap_at_vertex(v, a, b, Point(2, 2, 0), Point(0, 0, 1))) << "edge in the face";
  EXPECT_FALSE(overlap_at_vertex(v, a, b, Point(-1, -1, 0), Point(0, 0, 1))) << "edge in the plane, behind";
}

TEST(Exact, OverlapAtEdge) {
  const Point v(0, 0, 0), w(1, 0, 0), a(0, 1, 0);
  EXPECT_FALSE(overlap_at_edge(v, w, a, Point(0, -1, 0)));
  EXPECT_TRUE(overlap_at_edge(v, w, a, Point(7, 0.1, 0)));
  EXPECT_FALSE(overlap_at_edge(v, w, a, Point(7, 0.1, 5e-324)));
}

TEST(Exact, CrossingIsUpwardForFacesSeenFromAbove) {
  EXPECT_EQ(crossing_above(unit, Point(0.25, 0.25, -1)), 1);
  EXPECT_EQ(crossing_above(unit, Point(0.25, 0.25, 1)), 0);
  EXPECT_EQ(crossing_above({unit[0], unit[2], unit[1]}, Point(0.25, 0.25, -1)), -1);
  EXPECT_EQ(crossing_above(unit, Point(2, 2, -1)), 0);
}

TEST(Exact, LinesThroughEdgesAndVerticesCountOnce) {
  const TriangleMesh cube = shapes::cube(1);
  const auto winding = [&](const Point& p) {
    int sum = 0;
    for (std::int32_t t = 0; t < cube.triangles.rows(); ++t) sum += crossing_above(corners(cube, t), p);
    return sum;
  };
  EXPECT_EQ(winding(Point(0, 0, 0)), 1) << "through the diagonal of the top";
  EXPECT_EQ(winding(Point(0, 0, -2)), 0);
  EXPECT_EQ(winding(Point(1, 1, -2)), 0) << "through a vertical edge";
  EXPECT_EQ(winding(Point(-1, -1, -2)), 0);
  EXPECT_EQ(winding(Point(1, 0, -2)), 0) << "in the plane of a side";
  EXPECT_EQ(winding(Point(-1, 0, -2)), 0);
}

TEST(Exact, VolumeSign) {
  TriangleMesh cube = shapes::cube(1);
  std::vector<std::int32_t> all(12);
  for (int i = 0; i < 12; ++i) all[i] = i;
  EXPECT_EQ(volume_sign(cube, all), 1);
  EXPECT_EQ(volume_sign(shapes::flipped(cube), all), -1);
  EXPECT_EQ(volume_sign(shapes::moved(cube, Point(1e15, 0, 0)), all), 1);
  cube.vertices.col(2).setZero();
  EXPECT_EQ(volume_sign(cube, all), 0);
  cube.vertices(7, 2) = 5e-324;
  EXPECT_EQ(volume_sign(cube, all), 1) << "beyond intervals: rational";
}

TEST(Exact, DistanceIsATightLowerBound) {
  const auto expect = [](const Corners& a, const Corners& b, double d) {
    for (const double got : {exact_distance(a, b), exact_distance(b, a)}) {
      EXPECT_LE(got, d);
      EXPECT_GE(got, d * (1 - 1e-14));
    }
  };
  expect(unit, {Point(0.25, 0.25, 1e-30), Point(0, 0, 1), Point(1, 1, 1)}, 1e-30);
  expect(unit, {Point(-3, 0, 4), Point(-3, 0, 4), Point(-3, 0, 4)}, 5);
  expect(unit, {Point(2, 2, 0), Point(0.5, 2, 0), Point(-1, 2, 0)}, 1);
  expect(unit, {Point(0.5, -1, -2), Point(0.5, -1, 2), Point(0.5, -9, 0)}, 1);
}

}  // namespace
}  // namespace encage::proof
