// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/count_allocations.h"
#include "oracles/sampled.h"
#include "tests/broadphase/contact/ask_manifold.h"

#include <encage/distance.h>
#include <encage/error.h>
#include <encage/manifold.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;
using shapes::box;

const Vector up = Vector::UnitZ();

Motion at(double x, double y, double z, double scale = 1) { return Motion::resting(shift(x, y, z), scale); }

Pose turned(const Vector& axis, double angle, const Vector& to = Vector::Zero()) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  pose.translation() = to;
  return pose;
}

/// The same surface with its triangles and vertices in another order.
TriangleMesh shuffled(const TriangleMesh& mesh, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::vector<std::int32_t> vertex(static_cast<std::size_t>(mesh.vertices.rows())), triangle(mesh.triangles.rows());
  std::iota(vertex.begin(), vertex.end(), 0);
  std::iota(triangle.begin(), triangle.end(), 0);
  std::shuffle(vertex.begin(), vertex.end(), engine);
  std::shuffle(triangle.begin(), triangle.end(), engine);
  TriangleMesh result = mesh;
  for (std::size_t v = 0; v < vertex.size(); ++v) result.vertices.row(vertex[v]) = mesh.vertices.row(v);
  for (std::size_t t = 0; t < triangle.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      result.triangles(t, k) = vertex[mesh.triangles(triangle[t], (k + static_cast<int>(t)) % 3)];
    }
  }
  return result;
}

/// Area of the convex hull of points in the plane across `normal`.
double spanned(const Points& points, const Vector& normal) {
  const Vector u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Eigen::Vector2d> p;
  for (const ManifoldPoint& c : points) p.emplace_back(u.dot(c.point_b), v.dot(c.point_b));
  std::sort(p.begin(), p.end(),
            [](const auto& x, const auto& y) { return std::pair(x.x(), x.y()) < std::pair(y.x(), y.y()); });
  double twice = 0;
  for (int chain = 0; chain < 2; ++chain) {
    std::vector<Eigen::Vector2d> hull;
    for (const Eigen::Vector2d& q : p) {
      const auto right = [&] {
        const Eigen::Vector2d& s = hull[hull.size() - 2];
        const Eigen::Vector2d x = hull.back() - s, y = q - s;
        return x.x() * y.y() - x.y() * y.x() <= 0;
      };
      while (hull.size() > 1 && right()) hull.pop_back();
      hull.push_back(q);
    }
    for (std::size_t i = 1; i < hull.size(); ++i) {
      twice += hull[i - 1].x() * hull[i].y() - hull[i - 1].y() * hull[i].x();
    }
    std::reverse(p.begin(), p.end());
  }
  return 0.5 * twice;
}

void expect_all(const Points& points, const Vector& normal, double separation, double tolerance) {
  for (const ManifoldPoint& p : points) {
    EXPECT_LT((p.normal - normal).norm(), 1e-9) << p.normal.transpose();
    EXPECT_NEAR(p.separation, separation, tolerance);
  }
}

// ---- Boxes ------------------------------------------------------------------

struct Stack {
  std::string name;
  Pose upper;   ///< of a cube of half 1 on another one, apart from the gap
  double area;  ///< of the common face
};

std::vector<Stack> stacks() {
  const double octagon = 8 * (std::sqrt(2) - 1);
  return {{"flush", shift(0, 0, 2), 4},
          {"shifted", shift(0.5, 0.3, 2), 1.5 * 1.7},
          {"shifted along a side", shift(0.5, 0, 2), 1.5 * 2},
          {"turned by 45 degrees", turned(up, M_PI / 4, {0, 0, 2}), octagon},
          {"turned a little", turned(up, 0.1, {0.3, -0.2, 2}), 1.7 * 1.8 - 0.5}};
}

class BoxOnBox : public testing::TestWithParam<int> {
 protected:
  /// All stacks with a gap, in a world frame, asked both ways.
  static void expect_faces(double gap, double margin, const Pose& world, double scale, double far) {
    const TriangleMesh cube = shapes::cube(1);
    const int seed = GetParam();
    const ShapePtr a = make_shape(seed == 0 ? cube : shuffled(cube, seed)),
                   b = make_shape(seed == 0 ? cube : shuffled(cube, seed + 100));
    const double tolerance = 1e-9 * (scale + 1e-3 * far);
    for (const Stack& stack : stacks()) {
      SCOPED_TRACE(stack.name + " gap " + std::to_string(gap));
      Pose upper = stack.upper;
      upper.translation().z() += gap;
      upper.translation() *= scale;
      const Motion on_top = Motion::resting(world * upper, scale), below = Motion::resting(world, scale);
      const Vector normal = world.linear() * up;
      const ManifoldOptions options{.margin = margin * scale};
      for (const bool swapped : {false, true}) {
        SCOPED_TRACE(swapped ? "swapped" : "as is");
        const Points points = swapped ? contacts(*b, below, *a, on_top, options, scale + far)
                                      : contacts(*a, on_top, *b, below, options, scale + far);
        EXPECT_GE(points.size(), 3U);
        expect_all(points, swapped ? Vector(-normal) : normal, gap * scale, tolerance);
        EXPECT_GT(spanned(points, normal), 0.45 * stack.area * scale * scale);
        EXPECT_LT(spanned(points, normal), 1.001 * 4 * scale * scale);
      }
    }
  }
};

TEST_P(BoxOnBox, FlushOrAtAGapOrOverlapping) {
  for (const double gap : {0.0, 0.01, 0.0004, -0.0004, -0.01}) expect_faces(gap, 0.02, Pose::Identity(), 1, 0);
}

TEST_P(BoxOnBox, ExactlyFlushWithoutMargin) { expect_faces(0, 0, Pose::Identity(), 1, 0); }

TEST_P(BoxOnBox, InAnyFrame) {
  shapes::Random random(7);
  for (int round = 0; round < 8; ++round) {
    for (const double gap : {0.01, -0.01}) expect_faces(gap, 0.02, random_pose(random, 3), 1, 3);
  }
}

TEST_P(BoxOnBox, FarFromTheOriginAndScaled) {
  shapes::Random random(8);
  for (const double scale : {1e-3, 1.0, 256.0}) {
    for (const double gap : {0.01, -0.01}) {
      expect_faces(gap, 0.02, random_pose(random, 1e3 * scale), scale, 1e3 * scale);
      expect_faces(gap, 0.02, shift(1e5 * scale, -3e4 * scale, 5e4 * scale), scale, 1e5 * scale);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, BoxOnBox, testing::Values(0, 1, 2, 3));

TEST(Manifold, BoxesOfDifferentScales) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  for (const double gap : {0.005, 0.0, -0.005}) {
    const Points points = contacts(*cube, at(10, -20, 128 + 0.5 + gap, 0.5), *cube, at(0, 0, 0, 128), {.margin = 0.01});
    EXPECT_GE(points.size(), 4U);
    expect_all(points, up, gap, 1e-10);
    EXPECT_NEAR(spanned(points, up), 1, 1e-9);
  }
}

TEST(Manifold, BoxOnItsEdgeAndOnItsCorner) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  for (const double gap : {0.01, 0.0, -0.01}) {
    SCOPED_TRACE(gap);
    const Points edge =
        contacts(*cube, Motion::resting(turned(Vector::UnitX(), M_PI / 4, {0.25, 0, 1 + std::sqrt(2) + gap})), *cube,
                 Motion{}, {.margin = 0.02});
    EXPECT_GE(edge.size(), 2U);
    expect_all(edge, up, gap, 1e-9);
    double low = 2, high = -2;
    for (const ManifoldPoint& p : edge) {
      EXPECT_NEAR(p.point_a.y(), 0, 1e-9);
      low = std::min(low, p.point_b.x());
      high = std::max(high, p.point_b.x());
    }
    EXPECT_NEAR(low, -0.75, 1e-9);
    EXPECT_NEAR(high, 1, 1e-9);
    Pose pose = shift(0.25, 0.125, 1 + std::sqrt(3) + gap);
    pose.linear() = turn_between(Vector(-1, -1, -1), -up);
    const Points corner = contacts(*cube, Motion::resting(pose), *cube, Motion{}, {.margin = 0.02});
    ASSERT_EQ(corner.size(), 1U);
    expect_all(corner, up, gap, 1e-9);
    EXPECT_LT((corner[0].point_b - Vector(0.25, 0.125, 1)).norm(), 1e-9);
  }
}

// ---- Edges that cross --------------------------------------------------------

TEST(Manifold, CrossedEdgesTouchAlongTheirCommonPerpendicular) {
  const ShapePtr bar = make_shape(box({-3, -1, -1}, {3, 1, 1}));
  shapes::Random random(2);
  for (const double angle : {M_PI / 2, M_PI / 3, 0.3, 2.5}) {
    for (const double gap : {0.01, 1e-7, 0.0, -1e-7, -0.01, -0.2}) {
      SCOPED_TRACE(angle);
      SCOPED_TRACE(gap);
      const Pose lower = turned(Vector::UnitX(), M_PI / 4);
      const Pose upper = shift(0.125, 0, 2 * std::sqrt(2) + gap) * turned(up, angle) * lower;
      const Pose world = random_pose(random, 2);
      for (const Pose& frame : {Pose(Pose::Identity()), world}) {
        const Points points =
            contacts(*bar, Motion::resting(frame * upper), *bar, Motion::resting(frame * lower), {.margin = 0.02});
        ASSERT_EQ(points.size(), 1U);
        expect_all(points, frame.linear() * up, gap, 1e-9);
        EXPECT_LT((points[0].point_b - frame * Vector(0.125, 0, std::sqrt(2))).norm(), 1e-9);
        EXPECT_LT((points[0].point_a - frame * Vector(0.125, 0, std::sqrt(2) + gap)).norm(), 1e-9);
      }
    }
  }
}

// ---- Corners in notches --------------------------------------------------------

TEST(Manifold, ABlockInANotchTouchesBothWalls) {
  const ShapePtr notch = make_shape(notched()), block = make_shape(shapes::cube(0.3125));
  for (const double gap_x : {0.01, 0.0, -0.01}) {
    for (const double gap_y : {0.005, -0.005}) {
      const Points points =
          contacts(*block, at(-0.0625 + gap_x, -0.0625 + gap_y, 0.1), *notch, Motion{}, {.margin = 0.02});
      Points of_x, of_y;
      for (const ManifoldPoint& p : points) (p.normal.x() > 0.5 ? of_x : of_y).push_back(p);
      // Corners that are near both walls belong to one of them. The walls' common edge takes no part.
      EXPECT_GE(of_x.size(), 2U);
      EXPECT_GE(of_y.size(), 2U);
      EXPECT_GE(points.size(), 6U);
      expect_all(of_x, Vector::UnitX(), gap_x, 1e-9);
      expect_all(of_y, Vector::UnitY(), gap_y, 1e-9);
      EXPECT_GT(std::max(spanned(of_x, Vector::UnitX()), spanned(of_y, Vector::UnitY())), 0.2);
    }
  }
}

TEST(Manifold, AnEdgeInANotchTouchesBothWalls) {
  const ShapePtr notch = make_shape(notched()), block = make_shape(shapes::cube(0.3125));
  for (const double gap : {0.01, 0.0, -0.01}) {
    SCOPED_TRACE(gap);
    const double half = 0.3125, reach = half * std::sqrt(2);
    const Motion tilted =
        Motion::resting(turned(up, M_PI / 4, {-0.375 + reach + gap, -0.375 + reach + 0.5 * gap, 0.125}));
    // Its upright edges look along -x and -y, and each meets a wall.
    const Points points = contacts(*block, tilted, *notch, Motion{}, {.margin = 0.02});
    Points of_x, of_y;
    for (const ManifoldPoint& p : points) (p.normal.x() > 0.5 ? of_x : of_y).push_back(p);
    EXPECT_GE(of_x.size(), 2U);
    EXPECT_GE(of_y.size(), 2U);
    expect_all(of_x, Vector::UnitX(), gap, 1e-9);
    expect_all(of_y, Vector::UnitY(), 0.5 * gap, 1e-9);
  }
}

TEST(Manifold, ABlockInACornerOfThreeWallsTouchesAll) {
  const ShapePtr wall = make_shape(box({-1, -1, -1}, {1, 1, 1})), block = make_shape(shapes::cube(0.25));
  const CompoundPart parts[] = {{wall, shift(0, 0, -1)}, {wall, shift(-1, 0, 1)}, {wall, shift(0, -1, 1)}};
  const ShapePtr corner = make_compound(parts);
  for (const double gap : {0.01, 0.0, -0.01}) {
    SCOPED_TRACE(gap);
    const Points points = contacts(*block, at(0.25 + gap, 0.25 + gap, 0.25 + gap), *corner, Motion{}, {.margin = 0.02});
    for (const Vector& n : {Vector(Vector::UnitX()), Vector(Vector::UnitY()), up}) EXPECT_GE(along(points, n), 3) << n;
    for (const ManifoldPoint& p : points) EXPECT_NEAR(p.separation, gap, 1e-9);
  }
}

// ---- Round bodies of many triangles ---------------------------------------------

TEST(Manifold, SpheresOfTriangles) {
  const ShapePtr ball = make_shape(shapes::sphere(4));  // 2,048 triangles, whose faces are 0.002 inside
  shapes::Random random(3);
  for (int round = 0; round < 60; ++round) {
    const double gap = random(-0.1, 0.02);
    const Vector way = random_direction(random);
    const Pose below = random_pose(random, 2);
    Pose pose = random_pose(random, 0);
    pose.translation() = below.translation() + (2 + gap) * way;
    const Points points = contacts(*ball, Motion::resting(pose), *ball, Motion::resting(below), {.margin = 0.05}, 4);
    ASSERT_FALSE(points.empty());
    EXPECT_NEAR(least_separation(points), gap, 0.01);
    for (const ManifoldPoint& p : points) {
      // Vertices are within the margin up to this angle from the middle, and a facet may lean by as much more.
      EXPECT_GT(p.normal.dot(way), std::cos(std::acos(1 - 0.5 * (0.05 - gap)) + 0.15)) << gap;
      EXPECT_LT((p.point_b - below.translation()).norm(), 1.01);
      EXPECT_LT((p.point_a - pose.translation()).norm(), 1.01);
    }
  }
  // Vertices on the axes.
  for (int axis = 0; axis < 3; ++axis) {
    Pose pose = Pose::Identity();
    pose.translation()[axis] = 2.01;
    const Points points = contacts(*ball, Motion::resting(pose), *ball, Motion{}, {.margin = 0.011});
    EXPECT_NEAR(least_separation(points), 0.01, 1e-9);
    EXPECT_GE(along(points, Vector::Unit(axis)), 1);
  }
}

// ---- Deep overlap ------------------------------------------------------------------

TEST(Manifold, ThinPlatesRememberTheSideTheyCameFrom) {
  const ShapePtr large = make_shape(box({-1, -1, -0.03125}, {1, 1, 0.03125})),
                 small = make_shape(box({-0.5, -0.5, -0.03125}, {0.5, 0.5, 0.03125}));
  for (const double yaw : {0.0, 0.4}) {
    ManifoldCache cache;
    for (int step = 0; step <= 71; ++step) {
      const double gap = 0.01 - 0.001 * step;  // down to -0.061, nearly a plate's thickness
      SCOPED_TRACE(gap);
      const Motion falling = Motion::resting(turned(up, yaw, {0.1, 0.2, 0.0625 + gap}));
      const Points points = contacts(*small, falling, *large, Motion{}, {.margin = 0.02}, cache);
      EXPECT_GE(points.size(), 3U);
      expect_all(points, up, gap, 1e-9);
      // Without memory, the normals of the vertices select the face that they came through.
      const Points fresh = contacts(*small, falling, *large, Motion{}, {.margin = 0.02});
      EXPECT_GE(fresh.size(), 3U);
      expect_all(fresh, up, gap, 1e-9);
    }
  }
}

TEST(Manifold, CrossedThinPlates) {
  // Of two plates across each other, edges enter, and no vertex.
  const ShapePtr plate = make_shape(box({-1, -0.1875, -0.03125}, {1, 0.1875, 0.03125}));
  ManifoldCache cache;
  for (int step = 0; step <= 71; ++step) {
    const double gap = 0.01 - 0.001 * step;
    SCOPED_TRACE(gap);
    const Motion falling = Motion::resting(turned(up, M_PI / 2, {0, 0, 0.0625 + gap}));
    const Points points = contacts(*plate, falling, *plate, Motion{}, {.margin = 0.02}, cache);
    EXPECT_GE(points.size(), 3U);
    expect_all(points, up, gap, 1e-9);
  }
}

/// Pushes a into b along -z, from the gap to the given depth, and expects one side and a depth that grows.
void expect_grows(const Shape& a, const Pose& touching, const Shape& b, double deepest) {
  ManifoldCache cache;
  double before = -0.02;
  const int steps = 150;
  for (int step = 0; step <= steps; ++step) {
    const double overlap = -0.01 + (deepest + 0.01) * step / steps;
    SCOPED_TRACE(overlap);
    Pose pose = touching;
    pose.translation().z() -= overlap;
    const Points points = contacts(a, Motion::resting(pose), b, Motion{}, {.margin = 0.02}, cache);
    ASSERT_FALSE(points.empty());
    // What has entered a round bar beyond its middle leaves it sideways at worst; all points together push it back.
    double mean = 0;
    for (const ManifoldPoint& p : points) {
      EXPECT_GT(p.normal.z(), -0.25);
      mean += p.normal.z() / static_cast<double>(points.size());
    }
    EXPECT_GT(mean, 0.25);
    const double depth = -least_separation(points);
    EXPECT_GE(depth, before - 1e-9);
    EXPECT_LE(depth, overlap + 0.01);
    before = depth;
  }
  EXPECT_GT(before, 0.6 * deepest);
}

TEST(Manifold, CrossingTubesStayOnTheirSide) {
  const double r = 0.3;
  const ShapePtr tube = make_shape(cylinder(r, 2, 24, 40));
  const Pose along_x = turned(Vector::UnitY(), M_PI / 2), along_y = turned(Vector::UnitX(), M_PI / 2);
  const CompoundPart lying[] = {{tube, along_x}};
  const ShapePtr lower = make_compound(lying);
  Pose upper = along_y;
  upper.translation().z() = 2 * r;
  expect_grows(*tube, upper, *lower, 1.5 * r);
  upper = turned(up, 0.7) * along_x;
  upper.translation().z() = 2 * r;
  expect_grows(*tube, upper, *lower, 1.5 * r);
}

TEST(Manifold, LinkedRingsStayOnTheirSide) {
  // The upper ring hangs in the lower one's hole: tubes cross at the lower ring's top.
  const double r = 0.25;
  const ShapePtr ring = make_shape(shapes::torus(1, r, 64, 24));
  // The lower ring stands in the plane x = 0; its top is at z = 1. The upper ring stands in y = 0, and its bottom lies
  // on the lower ring's top, from below: links pull at each other.
  const CompoundPart standing[] = {{ring, turned(Vector::UnitY(), M_PI / 2)}};
  const ShapePtr lower = make_compound(standing);
  Pose upper = turned(Vector::UnitX(), M_PI / 2);
  // Tube centres: lower's top at z = 1; upper's bottom at z = 1 - 2 r when they touch inside the loop.
  upper.translation().z() = 2 - 2 * r;
  ManifoldCache cache;
  double before = -0.02;
  for (int step = 0; step <= 150; ++step) {
    const double overlap = -0.01 + (1.5 * r + 0.01) * step / 150;
    SCOPED_TRACE(overlap);
    Pose pose = upper;
    pose.translation().z() += overlap;
    const Points points = contacts(*ring, Motion::resting(pose), *lower, Motion{}, {.margin = 0.02}, cache);
    ASSERT_FALSE(points.empty());
    double mean = 0;
    for (const ManifoldPoint& p : points) {
      EXPECT_LT(p.normal.z(), 0.25);
      mean += p.normal.z() / static_cast<double>(points.size());
    }
    EXPECT_LT(mean, -0.25);
    const double depth = -least_separation(points);
    EXPECT_GE(depth, before - 1e-9);
    before = depth;
  }
  EXPECT_GT(before, 0.6 * 1.5 * r);
}

TEST(Manifold, BoxesOverlappingFarGetTheFaceTheyCameThrough) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  ManifoldCache cache;
  for (int step = 0; step <= 120; ++step) {
    const double overlap = 0.01 * step;  // past the middle
    SCOPED_TRACE(overlap);
    const Points points = contacts(*cube, at(0.1, 0.2, 2 - overlap), *cube, Motion{}, {.margin = 0.02}, cache);
    ASSERT_FALSE(points.empty());
    EXPECT_GE(along(points, up), 1);
    EXPECT_NEAR(least_separation(points), -overlap, 1e-9);
  }
}

// ---- Bodies that move ----

TEST(Manifold, BodiesThatApproachGetPointsBeforeTheyTouch) {
  const ShapePtr cube = make_shape(shapes::cube(1)), other = make_shape(shapes::cube(2));
  ManifoldPoint room[16];
  const auto ask = [&](const Motion& a, const Motion& b) {
    ManifoldCache cache;
    return Points(room, room + contact_manifold(*cube, a, *other, b, {.margin = 0.01}, cache, room));
  };
  // The gap is 0.5 at the start, and less than the margin at the end or not.
  const Motion falling{shift(0.1, 0.2, 3.5), shift(0.1, 0.2, 2.9)},
      short_of{shift(0.1, 0.2, 3.5), shift(0.1, 0.2, 3.02)}, rising{shift(0.1, 0.2, 3.5), shift(0.1, 0.2, 4)}, rest;
  Points points = ask(falling, rest);
  EXPECT_GE(points.size(), 3U);
  expect_all(points, up, 0.5, 1e-9);
  EXPECT_NEAR(spanned(points, up), 4, 1e-9);
  EXPECT_TRUE(ask(short_of, rest).empty());
  EXPECT_TRUE(ask(rising, rest).empty());
  // Only relative motion counts.
  const Motion fast{shift(0.1, 0.2, 3.5), shift(5.1, 0.2, 8.5)}, away{shift(0, 0, 0), shift(5, 0, 5)},
      after{shift(0, 0, 0), shift(0, 0, 0.6)};
  EXPECT_TRUE(ask(fast, away).empty());
  points = ask(at(0.1, 0.2, 3.5), after);
  EXPECT_GE(points.size(), 3U);
  expect_all(points, up, 0.5, 1e-9);
  ManifoldCache cache;
  EXPECT_EQ(contact_manifold(*cube, falling, HalfSpace{up, 2}, {.margin = 0.01}, cache, room), 4);
  expect_all({room, room + 4}, up, 0.5, 1e-9);
  EXPECT_EQ(contact_manifold(*cube, short_of, HalfSpace{up, 2}, {.margin = 0.01}, cache, room), 0);
}

// ---- Half-spaces -----------------------------------------------------------------

TEST(Manifold, HalfSpaces) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  shapes::Random random(4);
  for (int round = 0; round < 40; ++round) {
    const double gap = round % 4 == 0 ? 0 : random(-0.1, 0.02), scale = round % 3 == 0 ? 0.25 : 1;
    const Vector n = round % 2 == 0 ? up : random_direction(random);
    const HalfSpace plane{n, random(-2, 2)};
    // A face lies on the plane.
    Pose pose = Pose::Identity();
    pose.linear() = turn_between(up, n);
    pose.translation() = (plane.offset + scale + gap) * n + 3 * n.unitOrthogonal();
    const Points points = contacts(*cube, Motion::resting(pose, scale), plane, {.margin = 0.03});
    ASSERT_EQ(points.size(), 4U);
    expect_all(points, n, gap, 1e-12);
    EXPECT_NEAR(spanned(points, n), 4 * scale * scale, 1e-9);
    for (const ManifoldPoint& p : points) {
      EXPECT_NEAR(n.dot(p.point_b), plane.offset, 1e-12);
      EXPECT_LT((p.point_a - p.point_b - gap * n).norm(), 1e-12);
      EXPECT_NEAR(((pose.inverse() * p.point_a) / scale).cwiseAbs().minCoeff(), 1, 1e-12);
    }
    EXPECT_TRUE(
        contacts(*cube, Motion::resting(shift(n.x(), n.y(), n.z()) * pose, scale), plane, {.margin = 0.03}).empty() ||
        gap < -0.9);
  }
}

TEST(Manifold, HalfSpaceUnderAnEdgeACornerAndARoundBody) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  const HalfSpace floor;
  Points points = contacts(*cube, Motion::resting(turned(Vector::UnitX(), M_PI / 4, {0, 0, std::sqrt(2) - 0.01})),
                           floor, {.margin = 0.02});
  ASSERT_EQ(points.size(), 2U);
  expect_all(points, up, -0.01, 1e-12);
  Pose pose = shift(0, 0, std::sqrt(3) + 0.01);
  pose.linear() = turn_between(Vector(-1, -1, -1), -up);
  points = contacts(*cube, Motion::resting(pose), floor, {.margin = 0.02});
  ASSERT_EQ(points.size(), 1U);
  expect_all(points, up, 0.01, 1e-12);
  const ShapePtr segment = make_shape(shapes::mesh({{-1, 0, 0}, {1, 0, 0}}, {{0, 1, 1}}));
  points = contacts(*segment, at(0, 0, 0.3), floor, {.margin = 0.02, .radius_a = 0.31});
  ASSERT_EQ(points.size(), 2U);
  expect_all(points, up, -0.01, 1e-12);
  for (const ManifoldPoint& p : points) EXPECT_NEAR(p.point_a.z(), -0.01, 1e-12);
}

// ---- Spheres and capsules -----------------------------------------------------------

ShapePtr core(const std::vector<Vector>& corners) {
  std::vector<std::array<double, 3>> v;
  for (const Vector& c : corners) v.push_back({c[0], c[1], c[2]});
  const auto last = static_cast<std::int32_t>(v.size()) - 1;
  return make_shape(shapes::mesh(v, {{0, last, last}}));
}
ShapePtr core_of_three(const Vector& p, const Vector& q) {
  return make_shape(shapes::mesh({{p[0], p[1], p[2]}, {q[0], q[1], q[2]}, {q[0], q[1], q[2]}}, {{0, 1, 2}}));
}

/// Asks with the round body as a and as b; the answers must mirror each other. Returns the first.
Points both_ways(const Shape& round, const Motion& motion, const Shape& other, const Motion& motion_other,
                 double radius, double margin) {
  const Points one = contacts(round, motion, other, motion_other, {.margin = margin, .radius_a = radius}),
               two = contacts(other, motion_other, round, motion, {.margin = margin, .radius_b = radius});
  EXPECT_EQ(one.size(), two.size());
  for (const ManifoldPoint& p : one) {
    EXPECT_TRUE(std::any_of(two.begin(), two.end(), [&](const ManifoldPoint& q) {
      return (p.point_a - q.point_b).norm() < 1e-9 && (p.point_b - q.point_a).norm() < 1e-9 &&
             (p.normal + q.normal).norm() < 1e-9 && std::abs(p.separation - q.separation) < 1e-9;
    })) << p.normal.transpose();
  }
  return one;
}

TEST(Manifold, SpheresOnFacesEdgesAndCorners) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  const double radius = 0.3;
  for (const ShapePtr& ball : {core({Vector::Zero()}), core_of_three(Vector::Zero(), Vector::Zero())}) {
    for (const double gap : {0.01, 0.0, -0.05}) {
      for (const Vector& n : {Vector(0, 0, 1), Vector(1, 0, 1), Vector(1, -1, 1), Vector(-1, 0, 0), Vector(0, 1, 0)}) {
        SCOPED_TRACE(n.transpose());
        SCOPED_TRACE(gap);
        // The nearest point: on the feature, off the middle, on the face's diagonal once.
        for (const Vector& off : {Vector(0.3, -0.5, 0.25), Vector(0.25, 0.25, 0.25), Vector(0, 0, 0)}) {
          Vector on = off;
          for (int k = 0; k < 3; ++k) {
            if (n[k] != 0) on[k] = n[k];
          }
          const Vector normal = n.normalized(), centre = on + (radius + gap) * normal;
          const Points points = both_ways(*ball, at(centre.x(), centre.y(), centre.z()), *cube, Motion{}, radius, 0.02);
          ASSERT_EQ(points.size(), 1U);
          expect_all(points, normal, gap, 1e-9);
          EXPECT_LT((points[0].point_b - on).norm(), 1e-9);
          EXPECT_LT((points[0].point_a - on - gap * normal).norm(), 1e-9);
        }
      }
    }
  }
}

TEST(Manifold, ASphereWhoseCentreHasEnteredIsPushedOut) {
  const ShapePtr cube = make_shape(shapes::cube(1)), ball = core({Vector::Zero()});
  for (const double height : {0.95, 0.8, 0.5}) {
    const Points points = both_ways(*ball, at(0.1, 0.2, height), *cube, Motion{}, 0.3, 0.02);
    ASSERT_EQ(points.size(), 1U);
    expect_all(points, up, height - 1.3, 1e-9);
  }
  // Its centre is on the surface.
  const Points points = both_ways(*ball, at(0.1, 0.2, 1), *cube, Motion{}, 0.3, 0.02);
  ASSERT_EQ(points.size(), 1U);
  expect_all(points, up, -0.3, 1e-9);
}

TEST(Manifold, ASphereInANotchTouchesBothWalls) {
  const ShapePtr notch = make_shape(notched()), ball = core({Vector::Zero()});
  for (const double gap : {0.01, 0.0, -0.02}) {
    const double c = -0.375 + 0.3 + gap;
    const Points points = both_ways(*ball, at(c, c, 0.1), *notch, Motion{}, 0.3, 0.02);
    ASSERT_EQ(points.size(), 2U);
    EXPECT_EQ(along(points, Vector::UnitX()), 1);
    EXPECT_EQ(along(points, Vector::UnitY()), 1);
    for (const ManifoldPoint& p : points) EXPECT_NEAR(p.separation, gap, 1e-9);
    EXPECT_NE(points[0].feature, points[1].feature);
  }
}

TEST(Manifold, Capsules) {
  const ShapePtr cube = make_shape(shapes::cube(1)), notch = make_shape(notched());
  const double radius = 0.2;
  for (const ShapePtr& rod :
       {core({Vector(-0.375, 0, 0), Vector(0.375, 0, 0)}), core_of_three(Vector(-0.375, 0, 0), Vector(0.375, 0, 0))}) {
    for (const double gap : {0.01, 0.0, -0.02}) {
      SCOPED_TRACE(gap);
      // Flat on a face.
      Points points = both_ways(*rod, at(0.1, 0.2, 1 + radius + gap), *cube, Motion{}, radius, 0.02);
      EXPECT_GE(points.size(), 2U);
      expect_all(points, up, gap, 1e-9);
      double low = 2, high = -2;
      for (const ManifoldPoint& p : points) {
        low = std::min(low, p.point_b.x());
        high = std::max(high, p.point_b.x());
      }
      EXPECT_NEAR(low, -0.275, 1e-9);
      EXPECT_NEAR(high, 0.475, 1e-9);
      // Over the rim: one end on the face, and the edge.
      points = both_ways(*rod, at(0.9, 0.2, 1 + radius + gap), *cube, Motion{}, radius, 0.02);
      EXPECT_GE(points.size(), 2U);
      expect_all(points, up, gap, 1e-9);
      high = -2;
      for (const ManifoldPoint& p : points) high = std::max(high, p.point_b.x());
      EXPECT_NEAR(high, 1, 1e-9);
      // Across an edge, in the direction between its faces.
      const Vector n = Vector(1, 0, 1).normalized();
      Pose pose = Pose::Identity();
      pose.linear() = turn_between(Vector::UnitX(), Vector(1, 0, -1));
      pose.translation() = Vector(1, 0.3, 1) + (radius + gap) * n;
      points = both_ways(*rod, Motion::resting(pose), *cube, Motion{}, radius, 0.02);
      ASSERT_EQ(points.size(), 1U);
      expect_all(points, n, gap, 1e-9);
      EXPECT_LT((points[0].point_b - Vector(1, 0.3, 1)).norm(), 1e-9);
      // Upright on its end.
      pose = turned(Vector::UnitY(), M_PI / 2, {0.3, 0.3, 1 + 0.375 + radius + gap});
      points = both_ways(*rod, Motion::resting(pose), *cube, Motion{}, radius, 0.02);
      ASSERT_EQ(points.size(), 1U);
      expect_all(points, up, gap, 1e-9);
      // Along a notch.
      pose.translation() = Vector(-0.375 + radius + gap, -0.375 + radius + gap, 0);
      points = both_ways(*rod, Motion::resting(pose), *notch, Motion{}, radius, 0.02);
      EXPECT_EQ(along(points, Vector::UnitX()), 2);
      EXPECT_EQ(along(points, Vector::UnitY()), 2);
      EXPECT_EQ(points.size(), 4U);
      for (const ManifoldPoint& p : points) EXPECT_NEAR(p.separation, gap, 1e-9);
      // Beside an edge, parallel to it.
      pose = turned(up, M_PI / 2, Vector(1, 0, 1) + (radius + gap) * n);
      points = both_ways(*rod, Motion::resting(pose), *cube, Motion{}, radius, 0.02);
      EXPECT_EQ(points.size(), 2U);
      expect_all(points, n, gap, 1e-9);
    }
  }
}

TEST(Manifold, RoundBodiesAmongThemselves) {
  const ShapePtr ball = core({Vector::Zero()}), rod = core({Vector(-1, 0, 0), Vector(1, 0, 0)});
  for (const double gap : {0.01, 0.0, -0.1}) {
    SCOPED_TRACE(gap);
    const ManifoldOptions options{.margin = 0.02, .radius_a = 0.3, .radius_b = 0.2};
    const Vector n = Vector(1, 2, -2).normalized(), centre = (0.5 + gap) * n;
    Points points = contacts(*ball, at(centre.x(), centre.y(), centre.z()), *ball, Motion{}, options);
    ASSERT_EQ(points.size(), 1U);
    expect_all(points, n, gap, 1e-9);
    EXPECT_LT((points[0].point_b - 0.2 * n).norm(), 1e-9);
    // On a rod's side, and on its end.
    points = contacts(*ball, at(0.5, 0, 0.5 + gap), *rod, Motion{}, options);
    ASSERT_EQ(points.size(), 1U);
    expect_all(points, up, gap, 1e-9);
    points = contacts(*rod, Motion{}, *ball, at(1.5 + gap, 0, 0), {.margin = 0.02, .radius_a = 0.2, .radius_b = 0.3});
    ASSERT_EQ(points.size(), 1U);
    expect_all(points, -Vector::UnitX(), gap, 1e-9);
    // Rods crossed, and side by side.
    points = contacts(*rod, Motion::resting(turned(up, 1, {0.1, 0.1, 0.5 + gap})), *rod, Motion{}, options);
    ASSERT_EQ(points.size(), 1U);
    expect_all(points, up, gap, 1e-9);
    points = contacts(*rod, at(0.5, 0, 0.5 + gap), *rod, Motion{}, options);
    EXPECT_EQ(points.size(), 2U);
    expect_all(points, up, gap, 1e-9);
  }
}

TEST(Manifold, RadiiOfMeshes) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  const Points points =
      contacts(*cube, at(0, 0, 2.15), *cube, Motion{}, {.margin = 0.02, .radius_a = 0.1, .radius_b = 0.05});
  EXPECT_GE(points.size(), 4U);
  expect_all(points, up, 0, 1e-9);
  for (const ManifoldPoint& p : points) {
    EXPECT_NEAR(p.point_a.z(), 1.05, 1e-9);
    EXPECT_NEAR(p.point_b.z(), 1.05, 1e-9);
  }
}

// ---- Compounds --------------------------------------------------------------------

ShapePtr table() {
  const ShapePtr leg = make_shape(box({-0.125, -0.125, -0.5}, {0.125, 0.125, 0.5})),
                 top = make_shape(box({-1, -1, -0.125}, {1, 1, 0.125}));
  const CompoundPart parts[] = {{leg, shift(0.875, 0.875, 0.5)},
                                {leg, shift(-0.875, 0.875, 0.5)},
                                {leg, shift(-0.875, -0.875, 0.5)},
                                {leg, shift(0.875, -0.875, 0.5)},
                                {top, shift(0, 0, 1.125)}};
  return make_compound(parts);
}

TEST(Manifold, ATableStandsOnItsLegs) {
  const ShapePtr legs = table(), floor = make_shape(box({-5, -5, -1}, {5, 5, 0}));
  for (const double gap : {0.01, 0.0, -0.01}) {
    SCOPED_TRACE(gap);
    const Motion standing = Motion::resting(turned(up, 0.3, {1, 0.5, gap}));
    Points points = contacts(*legs, standing, *floor, Motion{}, {.margin = 0.02});
    std::set<std::uint64_t> features;
    for (const ManifoldPoint& p : points) features.insert(p.feature);
    EXPECT_EQ(features.size(), points.size());
    EXPECT_EQ(points.size(), 16U);
    expect_all(points, up, gap, 1e-9);
    EXPECT_NEAR(spanned(points, up), 4, 1e-9);
    points = contacts(*floor, Motion{}, *legs, standing, {.margin = 0.02});
    expect_all(points, -up, gap, 1e-9);
    EXPECT_NEAR(spanned(points, up), 4, 1e-9);
    points = contacts(*legs, standing, HalfSpace{}, {.margin = 0.02});
    EXPECT_EQ(points.size(), 16U);
    expect_all(points, up, gap, 1e-9);
    // A table on a table.
    points = contacts(*legs, at(0, 0, 1.25 + gap), *legs, Motion{}, {.margin = 0.02});
    expect_all(points, up, gap, 1e-9);
    EXPECT_NEAR(spanned(points, up), 4, 1e-9);
  }
}

// ---- Surfaces without an interior --------------------------------------------------

TEST(Manifold, SheetsAreTwoSided) {
  const ShapePtr sheet = make_shape(test::sheet(8, 2, 2)), cube = make_shape(shapes::cube(0.5));
  const ShapePtr hollow = make_shape(test::sheet(8, 2, 2), {.hollow = true});
  for (const ShapePtr& surface : {sheet, hollow}) {
    for (const double side : {1.0, -1.0}) {
      ManifoldCache cache;
      for (const double gap : {0.01, 0.001, 0.0, -0.001, -0.01}) {
        SCOPED_TRACE(gap * side);
        const Motion beside = at(0.07, 0.13, side * (0.5 + gap));
        const Points points = contacts(*cube, beside, *surface, Motion{}, {.margin = 0.02}, cache);
        EXPECT_GE(points.size(), 3U);
        expect_all(points, side * up, gap, 1e-9);
        EXPECT_NEAR(spanned(points, up), 1, 1e-6);
        const Points swapped = contacts(*surface, Motion{}, *cube, beside, {.margin = 0.02});
        EXPECT_GE(swapped.size(), 3U);
        expect_all(swapped, -side * up, gap, 1e-9);
      }
    }
  }
}

TEST(Manifold, AHollowBoxHoldsABallFromWithin) {
  const ShapePtr room = make_shape(shapes::cube(1), {.hollow = true}), cube = make_shape(shapes::cube(0.25));
  for (const double gap : {0.01, 0.001}) {
    const Points points = contacts(*cube, at(0.2, 0.1, -0.75 + gap), *room, Motion{}, {.margin = 0.02});
    EXPECT_GE(points.size(), 3U);
    expect_all(points, up, gap, 1e-9);
    const Points from_outside = contacts(*cube, at(0.2, 0.1, 1.25 + gap), *room, Motion{}, {.margin = 0.02});
    EXPECT_GE(from_outside.size(), 3U);
    expect_all(from_outside, up, gap, 1e-9);
    const Points round = contacts(*core({Vector::Zero()}), at(0.2, 0.1, -0.75 + gap), *room, Motion{},
                                  {.margin = 0.02, .radius_a = 0.25});
    ASSERT_EQ(round.size(), 1U);
    expect_all(round, up, gap, 1e-9);
  }
  EXPECT_TRUE(contacts(*cube, Motion{}, *room, Motion{}, {.margin = 0.02}).empty());
}

TEST(Manifold, TwoSheets) {
  const ShapePtr sheet = make_shape(test::sheet(4, 2, 1));
  ManifoldCache cache;
  for (const double gap : {0.01, 0.005, 0.001}) {
    const Points points =
        contacts(*sheet, Motion::resting(turned(up, 0.2, {0.1, 0.2, gap})), *sheet, Motion{}, {.margin = 0.02}, cache);
    EXPECT_GE(points.size(), 3U);
    expect_all(points, up, gap, 1e-9);
  }
}

// ---- One body inside another ---------------------------------------------------------

TEST(Manifold, ASolidInsideASolidGetsAContact) {
  const std::vector<Body> all = sample_bodies();
  const Body &box = find(all, "box"), &star = find(all, "star"), &shell = find(all, "shell");
  const Motion inside = Motion::resting(shift(0.1, 0.05, 0.3), 0.2);
  for (const bool swapped : {false, true}) {
    SCOPED_TRACE(swapped);
    const auto ask = [&](const Body& large) {
      return swapped ? contacts(*large.shape, Motion{}, *star.shape, inside)
                     : contacts(*star.shape, inside, *large.shape, Motion{});
    };
    const Points points = ask(box);
    ASSERT_FALSE(points.empty());
    EXPECT_LT(least_separation(points), 0);
    // A cavity is outside.
    EXPECT_TRUE(ask(shell).empty());
  }
}

// ---- Flat floors -----------------------------------------------------------------------

class FlatFloor : public testing::Test {
 protected:
  /// A box slides over a floor, the plane z = 0, at gaps from both sides of 0.
  void expect_flat(const Shape& floor, const std::string& name, double reach, int rounds) {
    SCOPED_TRACE(name);
    const ShapePtr block = make_shape(box({-0.4, -0.3, 0}, {0.4, 0.3, 0.5}));
    for (int round = 0; round < rounds && !HasFailure(); ++round) {
      const double gap = std::array{0.0, 0.004, 0.0001, -0.0001, -0.004}[static_cast<std::size_t>(round % 5)];
      const double yaw = round % 3 == 0 ? 0 : random_(-3, 3);
      Vector place = random_.point(reach);
      if (round % 7 == 0) place = (place * 4).array().round() / 4;
      place.z() = gap;
      SCOPED_TRACE(testing::Message() << "round " << round << " yaw " << yaw << " at " << place.transpose());
      const Motion sliding = Motion::resting(turned(up, yaw, place));
      for (const bool swapped : {false, true}) {
        const Points points = swapped ? contacts(floor, Motion{}, *block, sliding, {.margin = 0.01}, 5)
                                      : contacts(*block, sliding, floor, Motion{}, {.margin = 0.01}, 5);
        EXPECT_GE(points.size(), 3U);
        const Vector normal = swapped ? Vector(-up) : up;
        for (const ManifoldPoint& p : points) {
          EXPECT_LT((p.normal - normal).norm(), 1e-6) << p.normal.transpose() << " at " << p.point_b.transpose();
          EXPECT_NEAR(p.separation, gap, 1e-9);
        }
        EXPECT_GT(spanned(points, up), 0.45 * 0.48);
      }
    }
  }

  shapes::Random random_{11};
};

TEST_F(FlatFloor, OfASolidHasNoGhostContacts) {
  for (const int n : {1, 3, 10, 40}) {
    for (const double wander : {0.0, 0.3}) {
      const ShapePtr floor = make_shape(slab(random_, n, 2, 0.5, wander));
      expect_flat(*floor, "slab of " + std::to_string(n), 1.4, 60);
    }
  }
}

TEST_F(FlatFloor, OfASheetHasNoGhostContacts) {
  for (const int n : {1, 3, 10, 40}) {
    expect_flat(*make_shape(sheet(n, 2, 2)), "sheet of " + std::to_string(n), 1.4, 60);
    expect_flat(*make_shape(sheet(n, 2, 2), {.hollow = true}), "hollow sheet of " + std::to_string(n), 1.4, 60);
  }
}

TEST_F(FlatFloor, OfTwoCoplanarBoxesHasNoGhostContacts) {
  // One mesh whose top is in two parts that share an edge.
  const double x = 0.125;
  const TriangleMesh floor =
      shapes::mesh({{-2, -2, -1},
                    {x, -2, -1},
                    {2, -2, -1},
                    {-2, 2, -1},
                    {x, 2, -1},
                    {2, 2, -1},
                    {-2, -2, 0},
                    {x, -2, 0},
                    {2, -2, 0},
                    {-2, 2, 0},
                    {x, 2, 0},
                    {2, 2, 0}},
                   {{0, 4, 1},   {0, 3, 4},   {1, 5, 2}, {1, 4, 5}, {6, 7, 10}, {6, 10, 9}, {7, 8, 11},
                    {7, 11, 10}, {0, 1, 7},   {0, 7, 6}, {1, 2, 8}, {1, 8, 7},  {3, 10, 4}, {3, 9, 10},
                    {4, 11, 5},  {4, 10, 11}, {0, 9, 3}, {0, 6, 9}, {2, 5, 11}, {2, 11, 8}});
  expect_flat(*make_shape(floor), "two faces", 1.4, 200);
}

TEST_F(FlatFloor, RollsBallsAndRodsWithoutGhostContacts) {
  const ShapePtr ball = core({Vector::Zero()}), rod = core({Vector(-0.3, 0, 0), Vector(0.3, 0, 0)});
  const ShapePtr solid = make_shape(slab(random_, 12, 2, 0.5, 0.3)), thin = make_shape(sheet(12, 2, 2));
  for (const ShapePtr& floor : {solid, thin}) {
    for (int round = 0; round < 200; ++round) {
      const double gap = std::array{0.0, 0.004, -0.004}[static_cast<std::size_t>(round % 3)];
      Vector place = random_.point(1.4);
      place.z() = 0.2 + gap;
      const Motion rolling = Motion::resting(turned(up, random_(-3, 3), place));
      for (const ShapePtr& body : {ball, rod}) {
        const Points points = contacts(*body, rolling, *floor, Motion{}, {.margin = 0.01, .radius_a = 0.2});
        EXPECT_GE(points.size(), body == ball ? 1U : 2U);
        for (const ManifoldPoint& p : points) EXPECT_LT((p.normal - up).norm(), 1e-6) << p.normal.transpose();
        EXPECT_NEAR(least_separation(points), gap, 1e-9);
      }
    }
  }
}

// ---- Memory of the step before ------------------------------------------------------------

bool same(const Points& x, const Points& y) {
  return std::equal(x.begin(), x.end(), y.begin(), y.end(), [](const ManifoldPoint& p, const ManifoldPoint& q) {
    return p.point_a == q.point_a && p.point_b == q.point_b && p.normal == q.normal && p.separation == q.separation &&
           p.feature == q.feature && p.patch == q.patch;
  });
}

/// A step of a scene: two bodies that move about each other.
struct Step {
  const Body *a, *b;
  Motion at_a, at_b;
  bool first;
};

std::vector<Step> history(const std::vector<Body>& all) {
  shapes::Random random(12);
  std::vector<Step> steps;
  for (int scene = 0; scene < 60; ++scene) {
    const Body &a = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))],
               &b = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))];
    Pose pose_a = random_pose(random, 3), pose_b = random_pose(random, 3);
    const double size = 0.5 * (a.diagonal() + b.diagonal());
    const Vector way = random_direction(random);
    for (int step = 0; step < 12; ++step) {
      pose_a.linear() = random_rotation(random, 0.02) * pose_a.linear();
      pose_b.translation() = pose_a.translation() + way * size * (0.9 - 0.05 * step);
      steps.push_back({&a, &b, Motion::resting(pose_a), Motion::resting(pose_b), step == 0});
    }
  }
  return steps;
}

std::vector<Points> replay(const std::vector<Step>& steps) {
  std::vector<Points> all;
  ManifoldCache cache;
  for (const Step& step : steps) {
    if (step.first) cache.clear();
    all.push_back(contacts(*step.a->shape, step.at_a, *step.b->shape, step.at_b, {.margin = 0.05}, cache, 10));
  }
  return all;
}

TEST(ManifoldCache, OneHistoryGivesTheSamePointsOnEveryThread) {
  const std::vector<Body> all = sample_bodies();
  const std::vector<Step> steps = history(all);
  const std::vector<Points> expected = replay(steps);
  EXPECT_GT(std::count_if(expected.begin(), expected.end(), [](const Points& p) { return !p.empty(); }), 200);
  std::vector<std::vector<Points>> found(3);
  std::vector<std::thread> threads;
  for (auto& result : found) {
    threads.emplace_back([&result, &steps] {
      ManifoldCache cache;
      ManifoldPoint room[16];
      for (const Step& step : steps) {
        if (step.first) cache.clear();
        const int count =
            contact_manifold(*step.a->shape, step.at_a, *step.b->shape, step.at_b, {.margin = 0.05}, cache, room);
        result.emplace_back(room, room + count);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& result : found) {
    ASSERT_EQ(result.size(), expected.size());
    for (std::size_t i = 0; i < result.size(); ++i) EXPECT_TRUE(same(result[i], expected[i])) << i;
  }
}

TEST(ManifoldCache, PairsInTurnDoNotDisturbEachOther) {
  const std::vector<Body> all = sample_bodies();
  const std::vector<Step> steps = history(all);
  const std::vector<Points> expected = replay(steps);
  // All scenes at once, a step of each in turn.
  std::vector<std::size_t> begin;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].first) begin.push_back(i);
  }
  std::vector<ManifoldCache> caches(begin.size());
  for (std::size_t k = 0; k < 12; ++k) {
    for (std::size_t scene = 0; scene < begin.size(); ++scene) {
      const Step& step = steps[begin[scene] + k];
      const Points points =
          contacts(*step.a->shape, step.at_a, *step.b->shape, step.at_b, {.margin = 0.05}, caches[scene], 10);
      EXPECT_TRUE(same(points, expected[begin[scene] + k])) << scene << ", step " << k;
    }
  }
}

TEST(ManifoldCache, ClearForgets) {
  const ShapePtr large = make_shape(test::sheet(3, 2, 1)),
                 small = make_shape(box({-0.5, -0.5, -0.125}, {0.5, 0.5, 0.125}));
  ManifoldCache cache, moved;
  const auto ask = [&](double z, ManifoldCache& memory) {
    return contacts(*small, at(0.05, 0.1, z), *large, Motion{}, {.margin = 0.02}, memory);
  };
  const Points fresh = contacts(*small, at(0.05, 0.1, 0.01), *large, Motion{}, {.margin = 0.02});
  for (const double z : {0.13, 0.12, 0.11}) ask(z, cache);
  cache.clear();
  EXPECT_TRUE(same(ask(0.01, cache), fresh));
  // The memory goes with the cache that is moved.
  cache.clear();
  for (const double z : {0.13, 0.12, 0.11}) {
    ask(z, cache);
    ask(z, moved);
  }
  ManifoldCache other = std::move(moved);
  EXPECT_TRUE(same(ask(0.105, other), ask(0.105, cache)));
}

TEST(ManifoldCache, KeptFeaturesKeepTheirOrder) {
  const std::vector<Body> all = sample_bodies();
  const std::vector<Points> steps = replay(history(all));
  const std::vector<Step> scenes = history(all);
  int kept_points = 0, orders = 0;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    if (scenes[i].first) continue;
    std::map<std::uint64_t, std::size_t> before;
    for (std::size_t k = 0; k < steps[i - 1].size(); ++k) before[steps[i - 1][k].feature] = k;
    std::size_t last = 0;
    bool is_new = false;
    int kept = 0;
    for (const ManifoldPoint& p : steps[i]) {
      const auto found = before.find(p.feature);
      if (found == before.end()) {
        is_new = true;
        continue;
      }
      EXPECT_FALSE(is_new) << "new points come last";
      EXPECT_GE(found->second, last);
      last = found->second;
      ++kept;
    }
    kept_points += kept;
    orders += kept > 2;
  }
  EXPECT_GT(kept_points, 300);
  EXPECT_GT(orders, 20);
}

TEST(ManifoldCache, FeaturesOfARestingBoxStay) {
  shapes::Random random(13);
  const ShapePtr floor = make_shape(slab(random, 20, 2, 0.5, 0.3)), cube = make_shape(shapes::cube(0.5));
  ManifoldCache cache;
  std::vector<std::uint64_t> first;
  for (int step = 0; step < 50; ++step) {
    // It shakes by less than the margin.
    const Vector jitter = random.point(1e-4);
    Pose pose = turned(random_direction(random), random(-1e-4, 1e-4), Vector(0.1, 0.2, 0.5) + jitter);
    std::vector<std::uint64_t> features;
    for (const ManifoldPoint& p : contacts(*cube, Motion::resting(pose), *floor, Motion{}, {.margin = 0.01}, cache)) {
      features.push_back(p.feature);
    }
    EXPECT_GE(features.size(), 4U);
    if (step == 0) first = features;
    EXPECT_EQ(std::vector(features.begin(), features.begin() + 4), std::vector(first.begin(), first.begin() + 4));
  }
}

TEST(ManifoldCache, AllocatesNothingOnceItIsWarm) {
  std::vector<Body> all = sample_bodies();
  const std::vector<Step> steps = history(all);
  const ShapePtr compound = table(), floor = make_shape(box({-5, -5, -1}, {5, 5, 0}));
  std::vector<ManifoldCache> caches(2);
  ManifoldPoint room[16];
  int count = 0;
  const auto run = [&] {
    count = 0;
    for (const Step& step : steps) {
      if (step.first) caches[0].clear();
      count +=
          contact_manifold(*step.a->shape, step.at_a, *step.b->shape, step.at_b, {.margin = 0.05}, caches[0], room);
      count += contact_manifold(*step.a->shape, step.at_a, HalfSpace{}, {.margin = 0.05}, caches[1], room);
    }
    count += contact_manifold(*compound, Motion{}, *floor, Motion{}, {.margin = 0.05}, caches[1], room);
    count += contact_manifold(*compound, Motion{}, HalfSpace{}, {.margin = 0.05}, caches[1], room);
  };
  run();
  run();
  const long before = allocations;
  run();
  EXPECT_EQ(allocations, before);
  EXPECT_GT(count, 500);
}

// ---- Limits and bad input ------------------------------------------------------------------

TEST(ManifoldOptions, LimitThePoints) {
  shapes::Random random(14);
  const ShapePtr floor = make_shape(slab(random, 40, 2, 0.5, 0.3)), block = make_shape(slab(random, 30, 1, 0.5, 0.3));
  const Motion upside_down = Motion::resting(turned(Vector::UnitX(), M_PI, {0, 0, 0.001}));
  ManifoldCache cache;
  ManifoldPoint room[64];
  for (const int most : {1, 2, 4, 16, 60}) {
    for (const int per_patch : {1, 4}) {
      cache.clear();
      const ManifoldOptions options{.margin = 0.01, .most_points = most, .most_per_patch = per_patch};
      EXPECT_EQ(contact_manifold(*block, upside_down, *floor, Motion{}, options, cache, room), most);
      cache.clear();
      EXPECT_EQ(contact_manifold(*block, upside_down, *floor, Motion{}, options, cache, std::span(room).first(3)),
                std::min(most, 3));
    }
  }
  // Few points span as much as many do.
  const Points four = contacts(*block, upside_down, *floor, Motion{}, {.margin = 0.01, .most_points = 4});
  EXPECT_GT(spanned(four, up), 0.45 * 4);
}

TEST(BadInput, GetsNoPoints) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  ManifoldPoint room[16];
  ManifoldCache cache;
  const Motion above = at(0, 0, 2);
  const auto count = [&](const Motion& a, const Motion& b, const ManifoldOptions& options,
                         std::span<ManifoldPoint> points) {
    cache.clear();
    const int pair = contact_manifold(*cube, a, *cube, b, options, cache, points);
    cache.clear();  // the bodies change places
    EXPECT_EQ(contact_manifold(*cube, b, *cube, a, options, cache, points), pair);
    return pair;
  };
  ASSERT_GT(count(above, {}, {}, room), 0);
  EXPECT_EQ(count(above, {}, {}, {}), 0);
  for (const double bad : {nan, -1e-3, -infinity}) {
    EXPECT_EQ(count(above, {}, {.margin = bad}, room), 0);
    EXPECT_EQ(count(above, {}, {.radius_a = bad}, room), 0);
    EXPECT_EQ(count(above, {}, {.radius_b = bad}, room), 0);
    EXPECT_EQ(contact_manifold(*cube, {}, HalfSpace{}, {.margin = bad}, cache, room), 0);
  }
  for (const int most : {0, -1, std::numeric_limits<int>::min()}) {
    EXPECT_EQ(count(above, {}, {.most_points = most}, room), 0);
  }
  std::vector<Motion> unusable;
  for (const double bad : {nan, infinity, -infinity}) {
    unusable.push_back(at(bad, 0, 0));
    Pose pose = Pose::Identity();
    pose.linear()(1, 2) = bad;
    unusable.push_back(Motion::resting(pose));
    unusable.push_back(Motion::resting(Pose::Identity(), bad));
  }
  Pose mirrored = Pose::Identity();
  mirrored.linear()(0, 0) = -1;
  unusable.push_back(Motion::resting(mirrored));
  Pose sheared = Pose::Identity();
  sheared.linear()(0, 1) = 0.1;
  unusable.push_back(Motion::resting(sheared));
  Motion lost = above;
  lost.end.translation().z() = nan;
  unusable.push_back(lost);
  for (const double scale : {0.0, -1.0, 1e60}) unusable.push_back(Motion::resting(Pose::Identity(), scale));
  const auto error_of = [&](const auto& call) -> std::string {
    try {
      call();
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  };
  for (const Motion& motion : unusable) {
    const std::string why = motion_defect(motion);
    const auto ask = [&](const Motion& a, const Motion& b) {
      return error_of([&] { contact_manifold(*cube, a, *cube, b, {.margin = 1}, cache, room); });
    };
    EXPECT_EQ(ask(motion, above), "contact manifold: body a: " + why);
    EXPECT_EQ(ask(above, motion), "contact manifold: body b: " + why);
    EXPECT_EQ(error_of([&] { contact_manifold(*cube, motion, HalfSpace{}, {.margin = 1}, cache, room); }),
              "contact manifold: body a: " + why);
  }
  for (const Vector& normal : {Vector(nan, 0, 0), Vector(0, 0, 0), Vector(infinity, 0, 0)}) {
    EXPECT_EQ(contact_manifold(*cube, {}, HalfSpace{normal, 0}, {.margin = 1}, cache, room), 0);
  }
  EXPECT_EQ(contact_manifold(*cube, {}, HalfSpace{up, nan}, {.margin = 1}, cache, room), 0);
  EXPECT_GT(contact_manifold(*cube, {}, *cube, at(0, 0, 5), {.margin = infinity}, cache, room), 0);
}

TEST(BadInput, ShapesWithoutAFineMeshHaveNoContacts) {
  const std::vector<Body> all = sample_bodies();
  const Body cages(without_fine(find(all, "box").sample)), &box = find(all, "box");
  ManifoldPoint room[16];
  ManifoldCache cache;
  const CompoundPart parts[] = {{cages.shape, shift(0, 0, 2)}, {box.shape, shift(4, 0, 0)}};
  const ShapePtr compound = make_compound(parts);
  EXPECT_EQ(contact_manifold(*cages.shape, {}, *box.shape, at(0, 0, 2), {.margin = 1}, cache, room), 0);
  EXPECT_EQ(contact_manifold(*box.shape, {}, *cages.shape, at(0, 0, 2), {.margin = 1}, cache, room), 0);
  EXPECT_EQ(contact_manifold(*cages.shape, {}, HalfSpace{}, {.margin = 1}, cache, room), 0);
  EXPECT_EQ(contact_manifold(*compound, {}, *box.shape, {}, {.margin = 1}, cache, room), 0);
  EXPECT_GT(contact_manifold(*compound, {}, *box.shape, at(4, 0, 2), {.margin = 1}, cache, room), 0);
}

/// Soups that no mesh of a solid contains: degenerate triangles, doubled and folded ones, edges of three.
std::vector<TriangleMesh> soups() {
  TriangleMesh doubled = test::sheet(3, 2, 1);
  const TriangleMesh flat =
      shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}});
  TriangleMesh with_slivers = shapes::cube(1);
  for (int i = 0; i < 5; ++i) {
    const double x = 0.2 * i;
    with_slivers = shapes::with_triangle(with_slivers, {x, 0, 1}, {x, 0, 1}, {x, 0, 1});
    with_slivers = shapes::with_triangle(with_slivers, {x, 0, 1}, {x, 0.5, 1}, {x, 0.25, 1});
  }
  return {shapes::joined(doubled, shapes::flipped(doubled)),
          shapes::joined(doubled, doubled),
          flat,
          with_slivers,
          shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}),
          shapes::mesh({{0.5, 0.5, 0.5}}, {{0, 0, 0}}),
          shapes::joined(shapes::cube(1), shapes::cube(1)),
          shapes::joined(shapes::cube(1), shapes::moved(shapes::cube(1), {2, 0, 0})),
          shapes::flipped(shapes::cube(1))};
}

TEST(BadInput, DegenerateTrianglesGiveFinitePoints) {
  shapes::Random random(15);
  std::vector<ShapePtr> all;
  for (const TriangleMesh& mesh : soups()) {
    all.push_back(make_shape(mesh));
    all.push_back(make_shape(mesh, {.hollow = true}));
  }
  for (const Body& body : sample_bodies()) all.push_back(body.shape);
  int count = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < all.size(); ++j) {
      SCOPED_TRACE(testing::Message() << i << " and " << j);
      for (int round = 0; round < 6; ++round) {
        // A third of the poses puts features onto each other.
        Pose pose = random_pose(random, 1);
        if (round % 3 == 0) pose = shift(0.5 * random.integer(5), 0.5 * random.integer(5), random.integer(3));
        ManifoldCache cache;
        for (int again = 0; again < 2; ++again) {
          const Points points = contacts(*all[i], Motion::resting(pose), *all[j], Motion{},
                                         {.margin = round % 2 == 0 ? 0 : 0.1}, cache, 5);
          count += !points.empty();
        }
      }
    }
  }
  EXPECT_GT(count, 2000);
}

// ---- Dynamics ----------------------------------------------------------------------------------

struct Rigid {
  ShapePtr shape;
  Pose pose = Pose::Identity();  ///< the centre of mass is the body's origin
  Vector velocity = Vector::Zero(), spin = Vector::Zero();
  double mass = 1, inertia = 0.4;  ///< the same about every axis

  void push(const Vector& impulse, const Vector& point) {
    velocity += impulse / mass;
    spin += (point - pose.translation()).cross(impulse) / inertia;
  }
  Vector at(const Vector& point) const { return velocity + spin.cross(point - pose.translation()); }
  double energy() const { return 0.5 * (mass * velocity.squaredNorm() + inertia * spin.squaredNorm()); }
  Vector angular() const { return inertia * spin + mass * pose.translation().cross(velocity); }
  void advance(double time) {
    pose.translation() += time * velocity;
    if (spin.norm() > 0) {
      pose.linear() = Eigen::Quaterniond(Eigen::AngleAxisd(time * spin.norm(), spin.normalized()) * pose.linear())
                          .normalized()
                          .toRotationMatrix();
    }
  }
};

/// Sequential impulses without restitution; points that are apart may approach each other until they touch.
void collide(Rigid& a, Rigid& b, const Points& points, double step) {
  std::vector<double> impulse(points.size(), 0);
  for (int iteration = 0; iteration < 30; ++iteration) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const ManifoldPoint& p = points[i];
      const Vector middle = 0.5 * (p.point_a + p.point_b);
      const auto slowness = [&](const Rigid& body) {
        return 1 / body.mass + (middle - body.pose.translation()).cross(p.normal).squaredNorm() / body.inertia;
      };
      const double approach = p.normal.dot(a.at(middle) - b.at(middle)) + std::max(0.0, p.separation) / step;
      const double before = impulse[i];
      impulse[i] = std::max(0.0, before - approach / (slowness(a) + slowness(b)));
      a.push((impulse[i] - before) * p.normal, middle);
      b.push((before - impulse[i]) * p.normal, middle);
    }
  }
}

TEST(Dynamics, CollisionsKeepMomentumAndGainNoEnergy) {
  const std::vector<Body> all = sample_bodies();
  const char* const names[] = {"star", "torus", "l", "u", "box", "tetrahedron"};
  shapes::Random random(16);
  const double step = 1.0 / 240;
  int hits = 0, entered = 0;
  for (int scene = 0; scene < 30; ++scene) {
    SCOPED_TRACE(scene);
    Rigid a{find(all, names[random.integer(6)]).shape}, b{find(all, names[random.integer(6)]).shape};
    b.mass = 2.5;
    b.inertia = 0.9;
    a.pose = random_pose(random, 0.3);
    b.pose = random_pose(random, 0.3);
    b.pose.translation().x() += 3.6;
    a.velocity = Vector(2, 0, 0) + random.point(0.3);
    b.velocity = Vector(-2, 0, 0) + random.point(0.3);
    a.spin = random.point(1);
    b.spin = random.point(1);
    const Vector momentum = a.mass * a.velocity + b.mass * b.velocity;
    double energy = a.energy() + b.energy(), deepest = 0;
    ManifoldCache cache;
    bool hit = false;
    for (int t = 0; t < 480; ++t) {
      const Vector angular = a.angular() + b.angular();
      const double before = a.energy() + b.energy();
      const Points points =
          contacts(*a.shape, Motion::resting(a.pose), *b.shape, Motion::resting(b.pose), {.margin = 0.05}, cache, 10);
      collide(a, b, points, step);
      const double after = a.energy() + b.energy();
      EXPECT_LE(after, before * (1 + 1e-12));
      EXPECT_LT((a.angular() + b.angular() - angular).norm(), 1e-11);
      hit = hit || after < 0.9 * energy;
      if (!points.empty()) deepest = std::max(deepest, -least_separation(points));
      a.advance(step);
      b.advance(step);
    }
    EXPECT_LT((a.mass * a.velocity + b.mass * b.velocity - momentum).norm(), 1e-11);
    hits += hit;
    entered += deepest > 0.01;
  }
  EXPECT_GT(hits, 15);
  // Speculative contacts stop nearly all bodies before they enter. Nothing pushes out those that a turn takes in, whose
  // depths are heuristic.
  EXPECT_LT(entered, 10);
}

}  // namespace
}  // namespace encage::test
