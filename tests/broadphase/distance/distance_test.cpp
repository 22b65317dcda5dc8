// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/count_allocations.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/broadphase/separation/ask_pairs.h"

#include <encage/distance.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

constexpr double infinity = std::numeric_limits<double>::infinity();

DistanceResult ask(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                   const DistanceOptions& options = {}) {
  return distance(a, Motion::resting(pose_a), b, Motion::resting(pose_b), options);
}

double bound(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
             const CageDistanceOptions& options = {}) {
  return cage_distance_bound(a, Motion::resting(pose_a), b, Motion::resting(pose_b), options);
}

ShapePtr ring(double radius) {
  TriangleMesh mesh = shapes::torus(radius, 0.35 * radius, 48, 24);
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return make_shape(mesh);
}

/// Distance of the surfaces, in long double.
Real brute_force(const Body& a, const Motion& motion_a, const Body& b, const Motion& motion_b) {
  const auto ta = at_time(a.mesh(), a.origin(), motion_a, 0), tb = at_time(b.mesh(), b.origin(), motion_b, 0);
  Real least = infinity;
  for (const RealTriangle& x : ta) {
    for (const RealTriangle& y : tb) {
      if (distance_bound(x, y) < least) least = std::min(least, triangle_distance(x, y));
    }
  }
  return least;
}

// ---- Against brute force -------------------------------------------------

constexpr int distance_shards = 4;

class Distances : public testing::TestWithParam<int> {};

TEST_P(Distances, HoldAgainstExactBruteForce) {
  const twins::Tally figures = ask_pairs("distance", twins::body_distances(), 1'600, distance_shards, GetParam());
  EXPECT_GT(figures.rejected, figures.pairs / 5);
  EXPECT_LE(figures.far_kept, figures.far / 50);
  EXPECT_GT(figures.touching, figures.pairs / 20);
}
INSTANTIATE_TEST_SUITE_P(Shards, Distances, testing::Range(0, distance_shards));

TEST(TriangleDistances, HoldAgainstExactArithmetic) {
  const twins::Tally figures = ask_pairs("triangle-distance", twins::triangle_distances(), 20'000, 1, 0);
  EXPECT_GT(figures.rejected, figures.pairs / 5);
  EXPECT_GT(figures.touching, figures.pairs / 5);
  EXPECT_LE(figures.far_kept * 500, figures.far) << "bounds are apart by little more than rounding";
}

TEST(Distance, BoundsDifferByRoundingHoweverFarOrNear) {
  const std::vector<Body> all = sample_bodies();
  shapes::Random random(3);
  int near = 0;
  for (int round = 0; round < 400; ++round) {
    const Body &a = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))], &b = find(all, "star");
    const double scale_a = round % 3 == 0 ? 1e-3 : 1, scale_b = round % 5 == 0 ? 300 : 1;
    const double size = scale_a * a.diagonal() + scale_b * b.diagonal();
    Motion at_a = Motion::resting(random_pose(random, 10), scale_a);
    Motion at_b = Motion::resting(random_pose(random, 10), scale_b);
    if (round % 2 == 0) at_b.start.translation() = at_a.start.translation();
    const Vector way = random_direction(random);
    // The bodies are far apart, up to 1e6 sizes, or their surfaces are some 1e-12 to 1e-2 apart.
    at_b.start.translation() += way * size * (round % 4 == 0 ? std::pow(10, random(1, 6)) : 2);
    if (round % 4 != 0) {
      const DistanceResult found = distance(*a.shape, at_a, *b.shape, at_b);
      if (!(found.lower > 0)) continue;
      const Vector towards = (found.point_a - found.point_b).normalized();
      at_b.start.translation() += towards * (found.lower - size * std::pow(10, random(-12, -2)));
    }
    at_b.end = at_b.start;
    const DistanceResult found = distance(*a.shape, at_a, *b.shape, at_b);
    const Real truth = brute_force(a, at_a, b, at_b);
    const double apart = (at_a.start.translation() - at_b.start.translation()).norm();
    EXPECT_LE(static_cast<Real>(found.lower), truth * (1 + 1e-15L));
    if (found.lower > 0) {
      EXPECT_GE(static_cast<Real>(found.upper) * (1 + 1e-15L), truth);
    }
    if (a.solid()) {
      EXPECT_LE(found.upper - found.lower, 1e-13 * (size + apart)) << a.sample.name;
    }
    near += found.lower > 0 && found.lower < 1e-6 * size;
  }
  EXPECT_GT(near, 50);
}

TEST(Distance, LargeMeshesFarAwayTakeNoLonger) {
  const ShapePtr shape = ring(1);
  Pose b = Pose::Identity();
  b.linear() = Eigen::AngleAxisd(1, Vector(1, 2, 3).normalized()).toRotationMatrix();
  for (const double far : {1e1, 1e4, 1e6, 1e9, 1e14}) {
    b.translation() = Vector(0.6, -0.64, 0.48) * far;
    const DistanceResult found = ask(*shape, Pose::Identity(), *shape, b);
    EXPECT_GT(found.lower, far - 3);
    EXPECT_LE(found.upper - found.lower, 1e-13 * far);
  }
}

// ---- Known answers -----------------------------------------------------------

TEST(Distance, KnowsTheNearestFeatures) {
  const std::vector<Body> all = sample_bodies();
  const Shape& box = *find(all, "box").shape;  // [-1, 1]^3
  Pose turned = shift(5, 0, 0);
  turned.linear() = Eigen::AngleAxisd(M_PI / 4, Vector::UnitZ()).toRotationMatrix();
  struct Case {
    Pose pose;
    double distance;
  };
  const std::vector<Case> cases = {{shift(5, 0.25, 0.5), 3},     // faces
                                   {shift(5, 6, 0), 5},          // edges along z
                                   {shift(4, 5, 8), 7},          // corners: 2, 3, 6
                                   {turned, 4 - std::sqrt(2)}};  // edge and face
  for (const Case& c : cases) {
    const DistanceResult found = ask(box, Pose::Identity(), box, c.pose);
    EXPECT_LE(found.lower, c.distance);
    EXPECT_GE(found.upper, c.distance * (1 - 1e-15));
    EXPECT_LT(found.upper - found.lower, 1e-12);
    EXPECT_NEAR((found.point_a - found.point_b).norm(), c.distance, 1e-12);
    EXPECT_NEAR(found.point_a.cwiseAbs().maxCoeff(), 1, 1e-14);
    EXPECT_NEAR((c.pose.inverse() * found.point_b).cwiseAbs().maxCoeff(), 1, 1e-14);
    EXPECT_GE(found.triangle_a, 0);
    EXPECT_LT(found.triangle_b, 12);
  }
}

TEST(Distance, PointsLieOnTheirTriangles) {
  const std::vector<Body> all = sample_bodies();
  shapes::Random random(5);
  const Body &a = find(all, "star"), &b = find(all, "shell");
  for (int round = 0; round < 50; ++round) {
    const Motion at_a = Motion::resting(random_pose(random, 3), 2), at_b = Motion::resting(random_pose(random, 3));
    const DistanceResult found = distance(*a.shape, at_a, *b.shape, at_b);
    const auto off = [](const Body& body, const Motion& at, std::int32_t triangle, const Vector& point) {
      const auto triangles = at_time(body.mesh(), body.origin(), at, 0);
      return static_cast<double>(
          point_triangle_distance(point.cast<Real>(), triangles[static_cast<std::size_t>(triangle)]));
    };
    if (found.triangle_a >= 0) {
      EXPECT_LT(off(a, at_a, found.triangle_a, found.point_a), 1e-13);
    }
    if (found.triangle_b >= 0) {
      EXPECT_LT(off(b, at_b, found.triangle_b, found.point_b), 1e-13);
    }
    EXPECT_TRUE(found.triangle_a >= 0 || found.triangle_b >= 0);
    EXPECT_LE((found.point_a - found.point_b).norm(), found.upper + 1e-14);
  }
}

TEST(Distance, IsZeroInsideASolidAndNotInACavity) {
  const std::vector<Body> all = sample_bodies();
  const Shape &box = *find(all, "box").shape, &shell = *find(all, "shell").shape, &star = *find(all, "star").shape;
  const Motion small = Motion::resting(shift(0.1, 0.05, 0), 0.01);
  for (const bool swapped : {false, true}) {
    const Motion still;
    const DistanceResult held = swapped ? distance(star, small, box, still) : distance(box, still, star, small);
    EXPECT_EQ(held.lower, 0);
    EXPECT_EQ(held.upper, 0);
    EXPECT_EQ(held.point_a, held.point_b);
    EXPECT_LT((held.point_a - small.start.translation()).norm(), 0.05);
    EXPECT_EQ(swapped ? held.triangle_b : held.triangle_a, -1);
    EXPECT_GE(swapped ? held.triangle_a : held.triangle_b, 0);
    // This holds for any limit.
    EXPECT_EQ(distance(box, still, star, small, {.limit = 1e-3}).upper, 0);
    const double cages =
        swapped ? cage_distance_bound(star, small, shell, still) : cage_distance_bound(shell, still, star, small);
    EXPECT_EQ(cages, 0) << "cages have no cavity";
    const DistanceResult free = swapped ? distance(star, small, shell, still) : distance(shell, still, star, small);
    EXPECT_GT(free.lower, 0.1);
    EXPECT_LT(free.upper - free.lower, 1e-13);
  }
}

TEST(Distance, BodiesThatCrossAreNoDistanceApart) {
  const std::vector<Body> all = sample_bodies();
  const Shape& box = *find(all, "box").shape;
  const DistanceResult crossing = ask(box, Pose::Identity(), box, shift(1.3, 0.4, 0.7));
  EXPECT_EQ(crossing.lower, 0);
  EXPECT_EQ(crossing.upper, 0);
  EXPECT_LT((crossing.point_a - crossing.point_b).norm(), 1e-14);
  EXPECT_NEAR(crossing.point_a.cwiseAbs().maxCoeff(), 1, 1e-14);
  // Bodies that touch: rounding leaves it undecided whether they cross.
  const DistanceResult touching = ask(box, Pose::Identity(), box, shift(2, 0.25, 0.5));
  EXPECT_EQ(touching.lower, 0);
  EXPECT_LT(touching.upper, 1e-12);
  EXPECT_EQ(bound(box, Pose::Identity(), box, shift(2, 0.25, 0.5)), 0);
}

TEST(Distance, UnknownInteriorsMayHoldTheOther) {
  Sample sample;
  sample.hierarchy.fine = shapes::cube(1);
  sample.hierarchy.fine.triangles.conservativeResize(11, 3);
  sample.hierarchy.solid = Solid::surface_only;
  sample.source = sample.hierarchy.fine;
  const Body open(sample);
  const ShapePtr hollow = make_shape(sample.hierarchy, {.hollow = true});
  const ShapePtr ball = make_shape(shapes::scaled(shapes::sphere(1), 0.1));
  const DistanceResult maybe = ask(*open.shape, Pose::Identity(), *ball, Pose::Identity());
  EXPECT_EQ(maybe.lower, 0);
  EXPECT_GT(maybe.upper, 0.8);
  EXPECT_GT(ask(*hollow, Pose::Identity(), *ball, Pose::Identity()).lower, 0.8);
  EXPECT_GT(ask(*open.shape, Pose::Identity(), *ball, shift(3, 0, 0)).lower, 1.8);
}

TEST(Distance, FineErrorWidensTheBounds) {
  Sample sample = sample_shapes(1e-4).at(1);
  const Body body(sample);
  const DistanceResult found = ask(*body.shape, Pose::Identity(), *body.shape, shift(4, 0, 0));
  EXPECT_NEAR(found.upper - found.lower, 4e-4, 1e-6);
  EXPECT_NEAR(found.upper + found.lower, 4, 1e-6);
}

TEST(Distance, HintsLimitsAndTolerances) {
  const ShapePtr shape = ring(1);
  shapes::Random random(8);
  for (int round = 0; round < 100; ++round) {
    const Pose a = random_pose(random, 2), b = random_pose(random, 2);
    const DistanceResult found = ask(*shape, a, *shape, b);
    const DistanceResult again = ask(*shape, a, *shape, b, {.hint = {found.triangle_a, found.triangle_b}});
    EXPECT_LE(again.lower, found.upper);
    EXPECT_LE(found.lower, again.upper);
    const DistanceResult wrong = ask(*shape, a, *shape, b, {.hint = {1 << 30, -7}});
    EXPECT_EQ(wrong.lower, found.lower);
    EXPECT_EQ(wrong.triangle_a, found.triangle_a);
    const DistanceResult loose = ask(*shape, a, *shape, b, {.tolerance = 0.2});
    EXPECT_LE(loose.lower, found.upper);
    EXPECT_GE(loose.upper, found.lower);
    EXPECT_LE(loose.upper, loose.lower * 1.2 + 1e-12);
    if (!(found.lower > 0)) continue;
    const DistanceResult below = ask(*shape, a, *shape, b, {.limit = found.lower / 2});
    EXPECT_EQ(below.lower, found.lower / 2);
    EXPECT_EQ(below.upper, infinity);
    EXPECT_EQ(below.triangle_a, -1);
    const DistanceResult above = ask(*shape, a, *shape, b, {.limit = found.upper * 2});
    EXPECT_LE(above.lower, found.upper);
    EXPECT_LE(found.lower, above.upper);
    EXPECT_LT(above.upper - above.lower, 1e-12);
  }
}

TEST(Distance, PosesAndOptionsThatAreNotUsableProveNothing) {
  const std::vector<Body> all = sample_bodies();
  const Shape& box = *find(all, "box").shape;
  Pose stretched = shift(9, 0, 0);
  stretched.linear() *= 1.001;
  EXPECT_EQ(ask(box, Pose::Identity(), box, stretched).lower, 0);
  EXPECT_EQ(ask(box, Pose::Identity(), box, stretched).upper, infinity);
  EXPECT_EQ(bound(box, Pose::Identity(), box, stretched), 0);
  EXPECT_EQ(bound(box, Pose::Identity(), box, shift(std::nan(""), 0, 0)), 0);
  EXPECT_EQ(bound(box, Pose::Identity(), box, shift(9, 0, 0), {.enough = std::nan("")}), 0);
  EXPECT_EQ(ask(box, Pose::Identity(), box, shift(9, 0, 0), {.limit = -1}).lower, 0);
  // Only the start of the motion counts.
  Motion motion = Motion::resting(Pose::Identity());
  motion.end.linear() *= 5;
  EXPECT_NEAR(distance(box, motion, box, Motion::resting(shift(4, 0, 0))).lower, 2, 1e-12);
}

// ---- Cages ---------------------------------------------------------------

TEST(CageDistance, IsNeverLargerAndGetsTighterWithTheLevel) {
  const std::vector<Body> all = sample_bodies();
  shapes::Random random(11);
  double sum_coarse = 0, sum_fine = 0;
  int count = 0;
  for (int round = 0; round < 600; ++round) {
    const Body &a = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))], &b = find(all, "star");
    const Pose at_a = random_pose(random, 4), at_b = random_pose(random, 4);
    const DistanceResult truth = ask(*a.shape, at_a, *b.shape, at_b);
    const double coarse = bound(*a.shape, at_a, *b.shape, at_b);
    const double fine = bound(*a.shape, at_a, *b.shape, at_b, {.tolerance = 0, .finest_cage = 0});
    EXPECT_LE(coarse, truth.upper);
    EXPECT_LE(fine, truth.upper);
    EXPECT_GE(fine, coarse);
    const double enough = random(0.01, 2);
    const double capped = bound(*a.shape, at_a, *b.shape, at_b, {.enough = enough, .finest_cage = 0});
    EXPECT_LE(capped, enough);
    EXPECT_GE(capped * 1.011, std::min(enough, fine));
    const double loose = bound(*a.shape, at_a, *b.shape, at_b, {.tolerance = 0.5, .finest_cage = 0});
    EXPECT_LE(loose, fine * (1 + 1e-12));
    EXPECT_GE(loose * 1.5, fine * (1 - 1e-12));
    if (!(truth.lower > 1)) continue;
    sum_coarse += coarse / truth.lower;
    sum_fine += fine / truth.lower;
    ++count;
  }
  ASSERT_GT(count, 100);
  EXPECT_GT(sum_coarse / count, 0.75);
  EXPECT_GT(sum_fine / count, 0.95);
}

TEST(CageDistance, BodiesWithoutCagesAreInBalls) {
  const ShapePtr shape = ring(1);
  EXPECT_NEAR(bound(*shape, Pose::Identity(), *shape, shift(10, 0, 0)), 10 - 2 * 1.35, 1e-6);
  EXPECT_EQ(bound(*shape, Pose::Identity(), *shape, shift(2, 0, 0)), 0);
}

TEST(CageDistance, StandsInWhereThereIsNoFineMesh) {
  const std::vector<Body> all = sample_bodies();
  const Body cages(without_fine(find(all, "box").sample));
  const Shape& box = *find(all, "box").shape;
  const DistanceResult found = ask(*cages.shape, Pose::Identity(), box, shift(6, 0, 0));
  EXPECT_NEAR(found.lower, 6 - 2 * 1.05, 1e-6);
  EXPECT_EQ(found.upper, infinity);
}

TEST(Distance, CompoundsAreAsNearAsTheirNearestParts) {
  const std::vector<Body> all = sample_bodies();
  const Body& box = find(all, "box");
  const std::vector<CompoundPart> parts = {
      {box.shape, shift(-10, 0, 0), 1}, {find(all, "star").shape, shift(0, 8, 0), 1}, {box.shape, shift(3, 0, 0), 0.5}};
  const ShapePtr compound = make_compound(parts);
  const Pose at = shift(7, 0.25, 0.125);
  const DistanceResult found = ask(*compound, Pose::Identity(), *box.shape, at);
  EXPECT_LE(found.lower, 2.5);
  EXPECT_GE(found.upper, 2.5);
  EXPECT_LT(found.upper - found.lower, 1e-12);
  EXPECT_EQ(part_triangle(*compound, found.triangle_a).part, 2);
  const DistanceResult other =
      ask(*box.shape, at, *compound, Pose::Identity(), {.hint = {found.triangle_b, found.triangle_a}});
  EXPECT_EQ(part_triangle(*compound, other.triangle_b).part, 2);
  EXPECT_LE(other.lower, found.upper);
  constexpr std::int32_t least = std::numeric_limits<std::int32_t>::min();
  const DistanceResult unhinted = ask(*box.shape, at, *compound, Pose::Identity());
  for (const TrianglePair hint : {TrianglePair{0, least}, TrianglePair{least, 0}, TrianglePair{least, least}}) {
    const DistanceResult same = ask(*box.shape, at, *compound, Pose::Identity(), {.hint = hint});
    EXPECT_EQ(same.lower, unhinted.lower);  // the sanitizer reports an overflow of the hint
    EXPECT_EQ(same.upper, unhinted.upper);
  }
  const double cages = bound(*compound, Pose::Identity(), *box.shape, at, {.finest_cage = 0});
  EXPECT_LE(cages, 2.5);
  EXPECT_GT(cages, 2);
  EXPECT_EQ(bound(*compound, Pose::Identity(), *box.shape, at, {.enough = 0.5}), 0.5);
  EXPECT_EQ(ask(*compound, Pose::Identity(), *box.shape, at, {.limit = 2}).lower, 2);
  EXPECT_EQ(ask(*compound, Pose::Identity(), *compound, shift(0.5, 0.3, 0.2)).upper, 0);
}

TEST(Distance, OrderOfThePairAndUnitDoNotMatter) {
  const std::vector<Body> all = sample_bodies();
  Pose b = shift(0.3, 1.2, 2.3);
  b.linear() = Eigen::AngleAxisd(1.1, Vector(3, -2, 1).normalized()).toRotationMatrix();
  for (const Body& first : all) {
    for (const Body& second : all) {
      const DistanceResult one = ask(*first.shape, Pose::Identity(), *second.shape, b);
      const DistanceResult other = ask(*second.shape, b, *first.shape, Pose::Identity());
      EXPECT_LE(one.lower, other.upper);
      EXPECT_LE(other.lower, one.upper);
      for (const int exponent : {-60, 60}) {
        const Body first_scaled(scaled(first.sample, exponent)), second_scaled(scaled(second.sample, exponent));
        Pose pose = b;
        pose.translation() *= std::ldexp(1.0, exponent);
        const DistanceResult found = ask(*first_scaled.shape, Pose::Identity(), *second_scaled.shape, pose);
        EXPECT_NEAR(std::ldexp(found.lower, -exponent), one.lower, 1e-12);
        EXPECT_NEAR(std::ldexp(found.upper, -exponent), one.upper, 1e-12);
      }
    }
  }
}

TEST(Distance, QueriesDoNotAllocate) {
  const std::vector<Body> all = sample_bodies();
  double sum = 0;
  const long before = allocations;
  for (const Body& a : all) {
    for (const Body& b : all) {
      for (int i = 0; i < 10; ++i) {
        const Pose at = shift(0.3 * i, 0.2 * i, 0.1 * i);
        sum += ask(*a.shape, Pose::Identity(), *b.shape, at).lower;
        sum += bound(*a.shape, Pose::Identity(), *b.shape, at, {.finest_cage = 0});
      }
    }
  }
  EXPECT_EQ(allocations, before);
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace encage::test
