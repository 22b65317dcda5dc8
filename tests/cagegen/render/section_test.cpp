// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/section.h"

#include "tests/cagegen/render/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace encage::render {
namespace {

// Every end of a segment is the start of exactly one other.
void expect_loops(const std::vector<Segment>& segments) {
  const auto less = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::vector<Eigen::Vector3d> starts, ends;
  for (const Segment& s : segments) {
    starts.push_back(s.start);
    ends.push_back(s.end);
  }
  std::sort(starts.begin(), starts.end(), less);
  std::sort(ends.begin(), ends.end(), less);
  EXPECT_EQ(starts, ends);
}

TEST(Slice, SphereGivesACircle) {
  const TriangleMesh mesh = test::sphere(1, 4);
  const auto segments = slice(mesh, {Axis::y, 0.31});
  ASSERT_GT(segments.size(), 30U);
  expect_loops(segments);
  for (const Segment& s : segments) {
    EXPECT_EQ(s.start.y(), 0.31);
    EXPECT_NEAR(s.start.norm(), 1, 0.01);
  }
}

TEST(Slice, PlaneThroughVerticesStaysClosed) {
  // The octahedron's equator lies in the plane, edges and all.
  for (int rounds = 0; rounds < 3; ++rounds) {
    const auto segments = slice(test::sphere(1, rounds), {Axis::z, 0});
    EXPECT_FALSE(segments.empty());
    expect_loops(segments);
  }
}

TEST(Slice, PlaneThatTouchesOrMissesGivesNothingVisible) {
  EXPECT_TRUE(slice(test::cube(1), {Axis::x, 1.5}).empty());
  EXPECT_TRUE(slice(test::cube(1), {Axis::x, -1}).empty());
}

TEST(Section, FillsTheInsideAndDrawsTheOutline) {
  const TriangleMesh mesh = test::cube(1);
  const Cut cut{Axis::y, 0};
  const auto segments = slice(mesh, cut);
  std::vector<Eigen::Vector3d> points;
  for (const Segment& s : segments) points.push_back(s.start);
  const View view(camera_along(Axis::y, Axis::z), 100, 100, points);
  const Section section(segments, true, view, 100, 100, 2);
  // 93 of 100 pixels a side, in the middle (less the fit's thousandth).
  int inside = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) inside += section.inside(x, y);
  }
  EXPECT_NEAR(inside, 186 * 186, 4 * 186);
  EXPECT_TRUE(section.inside(100, 100));
  EXPECT_FALSE(section.inside(2, 100));
  EXPECT_EQ(section.contour(50, 50), 0);
  EXPECT_GT(section.contour(3, 50), 0.9F);
  EXPECT_GT(section.contour(50, 96), 0.9F);
  EXPECT_EQ(section.contour(0, 0), 0);
  // Without a fill only the outline is there.
  const Section outline(segments, false, view, 100, 100, 2);
  EXPECT_FALSE(outline.inside(100, 100));
  EXPECT_GT(outline.contour(3, 50), 0.9F);
}

}  // namespace
}  // namespace encage::render
