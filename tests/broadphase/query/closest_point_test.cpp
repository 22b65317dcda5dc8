// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "oracles/simd_targets.h"
#include "tests/broadphase/query/ask_body.h"

#include <gtest/gtest.h>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

/// A point anywhere; of every three one within 1e-6 of the surface, of every twelve one on a vertex.
Vector point_near(const PlacedBody& body, shapes::Random& random, int i) {
  const double size = body.box.diagonal().norm();
  const RealTriangle& t = body.triangles[static_cast<std::size_t>(random.integer(int(body.triangles.size())))];
  if (i % 12 == 4) return t[random.integer(3)].cast<double>();
  if (i % 3 != 1) return body.box.center() + random(0, 1) * size * random_direction(random);
  Real u = random(0, 1), v = random(0, 1);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  const Point on = t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
  return on.cast<double>() + random(0, 1e-6) * size * random_direction(random);
}

struct PointCounts {
  int points = 0, inside = 0, outside = 0, unknown_apart = 0;
  int features[3] = {0, 0, 0};
};

void check_closest(const PlacedBody& body, const Vector& p, shapes::Random& random, PointCounts& counts) {
  const double rounding = body.rounding(p);
  const auto distance = static_cast<double>(body.distance(p));
  const ClosestPoint found = closest_point(*body.shape, body.motion, p);
  ASSERT_TRUE(found.found());
  EXPECT_LE(found.lower, distance) << body.name;
  EXPECT_GE(found.upper, distance) << body.name;
  const RealTriangle& t = body.triangles[static_cast<std::size_t>(found.triangle)];
  // What a triangle that is hardly more than a segment may hide between its edges.
  const double width = width_of(t);
  const double hidden = width < 1e-7 * body.box.diagonal().norm() ? std::hypot(distance, width) - distance : 0;
  EXPECT_LE(found.upper - found.lower, 2 * rounding + 2 * hidden) << body.name;
  EXPECT_LE(static_cast<double>(point_triangle_distance(found.point.cast<Real>(), t)), rounding) << body.name;
  EXPECT_LE((found.point - p).norm(), found.upper);
  ++counts.features[static_cast<int>(found.feature)];
  const Point &a = t[found.corner], &b = t[(found.corner + 1) % 3];
  if (found.feature == SurfaceFeature::vertex) {
    EXPECT_LE((found.point.cast<Real>() - a).norm(), rounding);
  } else if (found.feature == SurfaceFeature::edge) {
    EXPECT_LE(point_segment_distance(found.point.cast<Real>(), a, b), rounding);
  }

  // The limit cuts, and nothing else.
  const double factor = random(0.5, 1.5);
  const ClosestPointOptions limited{.limit = distance * factor};
  if (std::abs(factor - 1) * distance > 4 * rounding) {
    const ClosestPoint cut = closest_point(*body.shape, body.motion, p, limited);
    EXPECT_EQ(cut.found(), factor > 1) << body.name;
    EXPECT_LE(cut.lower, distance);
    if (factor > 1) {
      EXPECT_EQ(cut.triangle, found.triangle);
    } else {
      EXPECT_GE(cut.lower, limited.limit - 2 * rounding);
    }
  }

  // Signs.
  ++counts.points;
  const PointSide side = contains(*body.shape, body.motion, p);
  const SignedDistance with_sign = signed_distance(*body.shape, body.motion, p);
  EXPECT_EQ(with_sign.closest.upper, found.upper);
  EXPECT_EQ(with_sign.closest.triangle, found.triangle);
  const bool solid = std::all_of(body.solid.begin(), body.solid.end(), [](bool s) { return s; });
  if (distance <= 0.01 * rounding) {
    EXPECT_NE(side, PointSide::outside) << body.name;
    if (body.exact.size() == 1) {
      EXPECT_EQ(side, PointSide::unknown) << body.name;
    }
  }
  if (side == PointSide::unknown) {
    if (solid && distance > rounding) ++counts.unknown_apart;
    if (body.exact.size() == 1) {
      EXPECT_EQ(with_sign.lower, -with_sign.upper);
      EXPECT_EQ(with_sign.upper, found.upper);
    }
    return;
  }
  EXPECT_EQ(with_sign.side, side) << body.name;
  ASSERT_EQ(side == PointSide::inside, body.holds(p)) << body.name << " at " << p.transpose();
  if (side == PointSide::outside) {
    ++counts.outside;
    EXPECT_EQ(with_sign.lower, found.lower);
    EXPECT_EQ(with_sign.upper, found.upper);
  } else {
    ++counts.inside;
    EXPECT_LE(with_sign.upper, 0);
    if (body.exact.size() == 1) {
      EXPECT_EQ(with_sign.lower, -found.upper);
      EXPECT_EQ(with_sign.upper, -found.lower);
    }
  }
}

TEST(ClosestPoint, IsThatOfAllTrianglesAndSignsAreThoseOfExactWindingNumbers) {
  const std::vector<PlacedBody> bodies = placed_bodies(21);
  const int count = question_count("ENCAGE_QUERY_POINTS", 20'000);
  shapes::Random random(22);
  PointCounts counts;
  for (int i = 0; i < count; ++i) {
    const PlacedBody& body = bodies[static_cast<std::size_t>(random.integer(static_cast<int>(bodies.size())))];
    check_closest(body, point_near(body, random, i), random, counts);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(counts.inside, count / 20);
  EXPECT_GT(counts.outside, count / 3);
  EXPECT_LE(counts.unknown_apart, count / 1000);
  for (const int features : counts.features) EXPECT_GT(features, count / 50);
}

// Of each part that holds the point, the depth in its own surface; the deepest one counts.
TEST(SignedDistance, OfCompoundsIsTheLeastOfTheirParts) {
  const std::vector<Body> bodies = sample_bodies();
  const ShapePtr box = find(bodies, "box").shape;
  const ShapePtr two = make_compound(std::vector<CompoundPart>{{box, shift(0)}, {box, shift(1.5), 0.5}});
  const auto at = [&](double x) { return signed_distance(*two, Motion{}, Vector(x, 0, 0)); };
  const auto expect = [](const SignedDistance& found, double value) {
    EXPECT_NEAR(found.lower, value, 1e-12);
    EXPECT_NEAR(found.upper, value, 1e-12);
    EXPECT_EQ(found.side, value < 0 ? PointSide::inside : PointSide::outside);
  };
  expect(at(0), -1);
  expect(at(0.75), -0.25);
  expect(at(1.25), -0.25);
  expect(at(2.5), 0.5);
  EXPECT_EQ(at(2).side, PointSide::unknown) << "on the surface";
  EXPECT_EQ(at(1).side, PointSide::unknown) << "on the surface of both";
}

TEST(SignedDistance, KnowsNoInsideOfOpenAndHollowBodies) {
  const std::vector<Body> bodies = sample_bodies();
  const Body& open = find(bodies, "open box");
  const SignedDistance in_open = signed_distance(*open.shape, Motion{}, Vector(0, 0, 0));
  EXPECT_EQ(in_open.side, PointSide::unknown);
  EXPECT_EQ(in_open.lower, -in_open.upper);
  EXPECT_EQ(contains(*open.shape, Motion{}, Vector(5, 0, 0)), PointSide::outside);
  const Body hollow(find(bodies, "box").sample, 1, true);
  const SignedDistance in_hollow = signed_distance(*hollow.shape, Motion{}, Vector(0.25, 0, 0));
  EXPECT_EQ(in_hollow.side, PointSide::outside);
  EXPECT_NEAR(in_hollow.lower, 0.75, 1e-12);
  EXPECT_EQ(contains(*hollow.shape, Motion{}, Vector(1, 0, 0)), PointSide::unknown);
}

// A body's source is not its fine mesh.
TEST(ClosestPoint, FineErrorCounts) {
  const Sample jittered = sample_shapes(1e-3)[1];
  const Body body(jittered);
  const Vector p(2, 0.25, 0.25);
  const ClosestPoint found = closest_point(*body.shape, Motion{}, p);
  EXPECT_LE(found.lower, found.upper - 2 * jittered.hierarchy.fine_error);
  Real least = 10;
  for (const RealTriangle& t : at_time(jittered.source, Vector::Zero(), Motion{}, 0)) {
    least = std::min(least, point_triangle_distance(p.cast<Real>(), t));
  }
  EXPECT_LE(found.lower, static_cast<double>(least));
  EXPECT_GE(found.upper, static_cast<double>(least));
  EXPECT_EQ(contains(*body.shape, Motion{}, Vector(1 + 0.5 * jittered.hierarchy.fine_error, 0, 0)), PointSide::unknown);
}

TEST(ClosestPoint, BatchesAnswerLikeSingleCallsOnEveryInstructionSetAndAllocateNothing) {
  shapes::Random random(23);
  for (const PlacedBody& body : placed_bodies(24)) {
    std::vector<Vector> points;
    for (int i = 0; i < 36; ++i) points.push_back(point_near(body, random, i));
    std::vector<ClosestPoint> closest(points.size());
    std::vector<SignedDistance> distances(points.size());
    std::vector<PointSide> sides(points.size());
    const long before = allocations;
    closest_points(*body.shape, body.motion, points, closest);
    signed_distances(*body.shape, body.motion, points, distances);
    contains(*body.shape, body.motion, points, sides);
    EXPECT_EQ(allocations, before);
    const auto add = [](std::vector<double>& all, const ClosestPoint& c) {
      all.insert(all.end(), {c.lower, c.upper, c.point[0], c.point[1], c.point[2], double(c.triangle),
                             double(c.feature), double(c.corner)});
    };
    const auto answers = expect_same_on_all_targets([&] {
      std::vector<double> all;
      for (const Vector& p : points) {
        add(all, closest_point(*body.shape, body.motion, p));
        const SignedDistance s = signed_distance(*body.shape, body.motion, p);
        all.insert(all.end(), {s.lower, s.upper, double(s.side), double(contains(*body.shape, body.motion, p))});
      }
      return all;
    });
    std::vector<double> batch;
    for (std::size_t i = 0; i < points.size(); ++i) {
      add(batch, closest[i]);
      batch.insert(batch.end(), {distances[i].lower, distances[i].upper, double(distances[i].side), double(sides[i])});
    }
    EXPECT_EQ(batch, answers) << body.name;
  }
}

}  // namespace
}  // namespace encage::test
