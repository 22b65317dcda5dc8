// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/count_allocations.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/broadphase/shape/stored_samples.h"

#include <encage/distance.h>
#include <encage/separated.h>
#include <encage/shape_cache.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

constexpr double endless = std::numeric_limits<double>::infinity();

/// Samples with fine meshes and without, small ones, and with a local origin far away.
std::vector<Body> bodies_over_planes(double jitter) {
  std::vector<Body> all;
  for (const Sample& sample : sample_shapes(jitter)) {
    all.emplace_back(sample, 1.7);
    if (!sample.hierarchy.levels.empty()) all.emplace_back(without_fine(sample));
    all.emplace_back(without_cages(scaled(sample, -4)), 0.3, true);
    Sample far = without_cages(sample);
    far.hierarchy.origin = Vector(1000, -250.25, 0.375);
    all.emplace_back(far);
  }
  for (const Sample& sample : flat_shapes(jitter)) all.emplace_back(sample);
  return all;
}

/// Least distance of a vertex to the plane, in long double.
Real least_height(const TriangleMesh& mesh, const Vector& origin, const Motion& motion, const HalfSpace& plane) {
  const Point n = plane.normal.cast<Real>();
  Real least = endless;
  for (const RealTriangle& t : at_time(mesh, origin, motion, 0)) {
    for (const Point& x : t) least = std::min(least, (n.dot(x) - Real(plane.offset)) / n.norm());
  }
  return least;
}

TEST(PlaneDistances, HoldAgainstAllVertices) {
  shapes::Random random(12);
  int above = 0, below = 0;
  for (const double jitter : {0.0, 1e-3}) {
    const std::vector<Body> all = bodies_over_planes(jitter);
    for (int round = 0; round < 3000; ++round) {
      SCOPED_TRACE(round);
      const Body& body = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))];
      const double size = body.diagonal(), far = round % 5 == 0 ? 1e6 : 3;
      Motion motion = Motion::resting(random_pose(random, far), body.scale);
      HalfSpace plane{random_direction(random), 0};
      if (round % 4 == 0) {  // many vertices are equally low
        motion.start.linear() = Pose::Identity().linear();
        plane.normal = round % 8 == 0 ? Vector(0, 0, 1) : Vector(-1, 0, 0);
      }
      motion.end = random_pose(random, 9);
      plane.offset = plane.normal.dot(body.centre(motion.start)) + random(-1, 1) * size;
      if (round % 3 == 0) plane.normal *= 1 + random(-9e-10, 9e-10);
      const PlaneDistance found = distance(*body.shape, motion, plane);
      const Real source = least_height(body.sample.source, body.origin(), motion, plane);
      EXPECT_LE(found.lower, source);
      EXPECT_GE(found.upper, source);
      EXPECT_EQ(found.vertex >= 0, body.has_fine());
      if (!body.has_fine()) {
        EXPECT_EQ(found.upper, endless);
        EXPECT_GE(found.lower, source - size) << "the finest cage is not far";
        continue;
      }
      const double error = body.sample.hierarchy.fine_error * body.scale;
      const double sizes =
          size + body.scale * body.origin().norm() + motion.start.translation().norm() + std::abs(plane.offset);
      EXPECT_LE(found.upper - found.lower, 2.001 * error + 2e-14 * sizes);
      // The point is the lowest vertex.
      const Real fine = least_height(body.mesh(), body.origin(), motion, plane);
      const Point vertex = motion.start.linear().cast<Real>() *
                               (Real(body.scale) * (body.origin() + body.mesh().vertex(found.vertex)).cast<Real>()) +
                           motion.start.translation().cast<Real>();
      EXPECT_LE((found.point.cast<Real>() - vertex).norm(), 1e-14 * sizes);
      EXPECT_NEAR(static_cast<double>(plane.normal.cast<Real>().dot(vertex) - Real(plane.offset)),
                  static_cast<double>(fine), 2e-9 * size + 1e-14 * sizes);
      EXPECT_NEAR(plane.normal.dot(found.foot), plane.offset, 2e-9 * size + 2e-14 * sizes);
      if (found.lower > 0) {
        EXPECT_TRUE(separated(*body.shape, Motion::resting(motion.start, motion.scale), plane,
                              std::max(0.0, found.lower - 1e-8 * sizes))
                        .separated);
      }
      ++(source > 0 ? above : below);
    }
  }
  EXPECT_GT(above, 500);
  EXPECT_GT(below, 500);
}

TEST(PlaneDistances, OfEquallyLowVerticesTheFirstCounts) {
  const ShapePtr box = make_shape(shapes::box({0, 0, 0}, {1, 1, 1}));
  const TriangleMesh mesh = shapes::box({0, 0, 0}, {1, 1, 1});
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const HalfSpace plane{sign * Vector::Unit(axis), -3};
      const PlaneDistance found = distance(*box, {}, plane);
      std::int32_t first = 0;
      while (sign * mesh.vertices(first, axis) != std::min(0.0, sign)) ++first;
      EXPECT_EQ(found.vertex, first);
      EXPECT_NEAR(found.lower, 3 + std::min(0.0, sign), 1e-13);
    }
  }
}

TEST(PlaneDistances, Limits) {
  shapes::Random random(13);
  for (const Body& body : bodies_over_planes(0)) {
    for (int round = 0; round < 20; ++round) {
      const Motion motion = Motion::resting(random_pose(random, 3), body.scale);
      const HalfSpace plane{random_direction(random), random(-2, 2)};
      const PlaneDistance whole = distance(*body.shape, motion, plane);
      const double limit = whole.lower + random(-1, 1);
      const PlaneDistance found = distance(*body.shape, motion, plane, {.limit = limit});
      if (limit > whole.upper) {
        EXPECT_EQ(found.lower, whole.lower);
        EXPECT_EQ(found.upper, whole.upper);
        EXPECT_EQ(found.vertex, whole.vertex);
      } else if (limit < whole.lower - 1e-9) {
        EXPECT_NEAR(found.lower, limit, 1e-9);
        EXPECT_LE(found.lower, limit);
        EXPECT_EQ(found.upper, endless);
        EXPECT_EQ(found.vertex, -1);
      }
    }
    EXPECT_EQ(distance(*body.shape, {}, HalfSpace{}, {.limit = -endless}).lower, -endless);
  }
}

TEST(PlaneDistances, CompoundsAreAsLowAsTheirLowestParts) {
  const std::vector<Body> all = bodies_over_planes(0);
  shapes::Random random(14);
  for (int round = 0; round < 300; ++round) {
    std::vector<CompoundPart> parts;
    std::vector<const Body*> bodies;
    while (parts.size() < 4) {
      const Body& body = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))];
      if (!body.has_fine()) continue;
      bodies.push_back(&body);
      parts.push_back({body.shape, random_pose(random, 2), body.scale});
    }
    const ShapePtr compound = make_compound(parts);
    const Motion motion = Motion::resting(random_pose(random, 2), random(0.5, 2));
    const HalfSpace plane{random_direction(random), random(-2, 2)};
    PlaneDistance least;
    least.upper = endless;
    std::int32_t vertex = -1, before = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      Pose pose = motion.start;
      pose.linear() = motion.start.linear() * parts[i].pose.linear();
      pose.translation() = motion.start * Vector(motion.scale * parts[i].pose.translation());
      const PlaneDistance part = distance(*parts[i].shape, Motion::resting(pose, motion.scale * parts[i].scale), plane);
      if (part.upper < least.upper) {
        least = part;
        vertex = before + part.vertex;
      }
      before += static_cast<std::int32_t>(bodies[i]->mesh().vertices.rows());
    }
    const PlaneDistance found = distance(*compound, motion, plane);
    EXPECT_NEAR(found.lower, least.lower, 1e-9);
    EXPECT_NEAR(found.upper, least.upper, 1e-9);
    EXPECT_LE(found.lower, least.upper);
    EXPECT_GE(found.upper, least.lower);
    EXPECT_EQ(found.vertex, vertex);
  }
}

TEST(PlaneDistances, WhatIsNotUsableProvesNothing) {
  const ShapePtr box = make_shape(shapes::cube(1));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_nothing = [&](const Motion& motion, const HalfSpace& plane, double limit = endless) {
    const PlaneDistance found = distance(*box, motion, plane, {.limit = limit});
    EXPECT_EQ(found.lower, -endless);
    EXPECT_EQ(found.upper, endless);
    EXPECT_EQ(found.vertex, -1);
  };
  Motion mirrored, drifted;
  mirrored.start.linear()(1, 1) = -1;
  drifted.start.linear()(1, 1) = 1 + 1e-8;
  expect_nothing(mirrored, {});
  expect_nothing(drifted, {});
  expect_nothing(Motion::resting(shift(nan)), {});
  expect_nothing(Motion::resting(shift(0), 0), {});
  expect_nothing({}, {Vector(0, 0, 2), 0});
  expect_nothing({}, {Vector(0, nan, 1), 0});
  expect_nothing({}, {Vector::UnitZ(), nan});
  expect_nothing({}, {Vector::UnitZ(), endless});
  expect_nothing({}, {}, nan);
  // The end of the motion does not count.
  Motion lost;
  lost.end.translation().x() = nan;
  EXPECT_GT(distance(*box, lost, {Vector::UnitZ(), -5}).lower, 3);
  EXPECT_NEAR(distance(*box, Motion::resting(shift(0, 0, 1e140)), {}).upper / 1e140, 1, 1e-12);
}

TEST(PlaneDistances, MeshesOnDemand) {
  const StoredSamples stored;
  ShapeCache cache({.budget_bytes = stored.room_for_a_pair(), .mode = LoadMode::copy});
  shapes::Random random(15);
  for (const auto& file : stored.files) {
    SCOPED_TRACE(file.filename().string());
    const ShapePtr cached = cache.load(file), loaded = load_shape(file);
    for (int round = 0; round < 20; ++round) {
      const Motion motion = Motion::resting(random_pose(random, 3));
      const HalfSpace plane{random_direction(random), random(-2, 2)};
      const PlaneDistance found = distance(*cached, motion, plane), expected = distance(*loaded, motion, plane);
      EXPECT_NEAR(found.lower, expected.lower, 1e-12);
      EXPECT_NEAR(found.upper, expected.upper, 1e-12);
      EXPECT_EQ(found.vertex, expected.vertex);
      const PlaneDistance limited = distance(*cached, motion, plane, {.limit = expected.lower - 1});
      EXPECT_LE(limited.lower, expected.lower - 1);
      EXPECT_GE(limited.lower, expected.lower - 1 - 1e-12);
    }
  }
  // A mesh that cannot be read leaves the cages.
  for (const auto& file : stored.files) {
    ShapeCache whole({.budget_bytes = std::int64_t{1} << 40, .mode = LoadMode::copy});
    const ShapePtr shape = whole.load(file);
    const double truth = distance(*load_shape(file, {}, LoadMode::copy), {}, {Vector::UnitZ(), -7}).lower;
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    const PlaneDistance found = distance(*shape, {}, {Vector::UnitZ(), -7});
    EXPECT_LE(found.lower, truth);
    EXPECT_GT(found.lower, truth - 1);
    EXPECT_EQ(found.vertex, -1);
  }
}

TEST(PlaneDistances, DoNotAllocate) {
  const std::vector<Body> all = bodies_over_planes(0);
  double sum = 0;
  const long before = allocations;
  for (const Body& body : all) {
    sum += distance(*body.shape, Motion::resting(shift(1, 2, 3), body.scale), HalfSpace{}).lower;
  }
  EXPECT_EQ(allocations, before);
  EXPECT_NE(sum, 0);
}

}  // namespace
}  // namespace encage::test
