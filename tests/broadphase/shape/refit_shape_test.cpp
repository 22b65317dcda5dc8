// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/shape/shape.h"
#include "oracles/body.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"

#include <encage/contact.h>
#include <encage/distance.h>
#include <encage/error.h>
#include <encage/manifold.h>
#include <encage/separated.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

/// Vertices in the body frame, waved by a share of the size and moved.
Vertices waved(const TriangleMesh& mesh, const Vector& origin, double share, double phase, const Vector& by) {
  Vertices vertices = mesh.vertices;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    const Vector p = vertices.row(v).transpose();
    const Vector wave(std::sin(3 * p.y() + phase), std::sin(4 * p.z() + 2 * phase), std::cos(2 * p.x() + phase));
    vertices.row(v) = (p + share * wave + origin + by).transpose();
  }
  return vertices;
}

std::vector<Body> meshes() {
  std::vector<Body> all;
  for (Body& body : sample_bodies()) {
    if (body.has_fine()) all.push_back(std::move(body));
  }
  return all;
}

TEST(RefitShape, AnswersAsAShapeMadeAnew) {
  shapes::Random random(5);
  int apart = 0, touching = 0;
  for (const Body& body : meshes()) {
    ShapePtr moving = body.shape;
    for (int step = 0; step < 6; ++step) {
      SCOPED_TRACE(testing::Message() << body.sample.name << ", step " << step);
      const Vector by = step == 5 ? Vector(1000, 0, 0) : Vector(0.1 * step, 0, 0);
      const TriangleMesh moved{waved(body.mesh(), body.origin(), 0.02 * step, step, by), body.mesh().triangles};
      moving = refit_shape(*moving, moved.vertices);
      const ShapePtr anew = make_shape(moved);
      EXPECT_EQ(moving->simple().solid != Solid::surface_only, body.solid());
      EXPECT_EQ(level_count(*moving), 0);
      EXPECT_DOUBLE_EQ(moving->simple().fine_error, anew->simple().fine_error);
      for (int round = 0; round < 20; ++round) {
        Motion at = Motion::resting(random_pose(random, 1.5));
        at.start.translation() += by + body.origin();
        at.end = at.start;
        const ShapePtr& other = body.shape;
        const DistanceResult refitted = distance(*moving, Motion{}, *other, at),
                             expected = distance(*anew, Motion{}, *other, at);
        // An open mesh that make_shape() gets may hold the other one; the capped source of the sample may not.
        if (moving->simple().solid == anew->simple().solid) {
          // Which of equally near triangles it is depends on the tree.
          EXPECT_NEAR(refitted.lower, expected.lower, 1e-12 * (1 + by.norm()));
          EXPECT_NEAR(refitted.upper, expected.upper, 1e-12 * (1 + by.norm()));
          EXPECT_EQ(separated(*moving, Motion{}, *other, at, {.margin = 0.05}).separated,
                    separated(*anew, Motion{}, *other, at, {.margin = 0.05}).separated);
        }
        (refitted.upper > 0 ? apart : touching) += 1;
      }
    }
  }
  EXPECT_GT(apart, 200);
  EXPECT_GT(touching, 200);
}

TEST(RefitShape, KeepsWhatContactsKnowOfTheTriangles) {
  const TriangleMesh ball = shapes::sphere(3);
  const ShapePtr shape = make_shape(ball), ground = make_shape(shapes::box({-4, -4, -1}, {4, 4, 0}));
  Motion at = Motion::resting(shift(0, 0, 1));
  ManifoldPoint points[16];
  ManifoldCache cache;
  ASSERT_GT(contact_manifold(*shape, at, *ground, Motion{}, {.margin = 0.1}, cache, points), 0);
  // Flattened, it no longer reaches the ground.
  Vertices flat = ball.vertices;
  flat.col(2) *= 0.5;
  const ShapePtr low = refit_shape(*shape, flat);
  EXPECT_EQ(contact_manifold(*low, at, *ground, Motion{}, {.margin = 0.1}, cache, points), 0);
  at = Motion::resting(shift(0, 0, 0.5));
  const int count = contact_manifold(*low, at, *ground, Motion{}, {.margin = 0.01}, cache, points);
  ASSERT_GT(count, 0);
  for (int i = 0; i < count; ++i) EXPECT_NEAR(points[i].normal.z(), 1, 0.05);
  EXPECT_EQ(low->simple().features().twin, make_shape({flat, ball.triangles})->simple().features().twin);
}

TEST(RefitShape, FromManyThreads) {
  const TriangleMesh ball = shapes::sphere(3);
  const ShapePtr shape = make_shape(ball);
  std::vector<ShapePtr> results(4);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < results.size(); ++i) {
    threads.emplace_back([&, i] { results[i] = refit_shape(*shape, (1 + static_cast<double>(i)) * ball.vertices); });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < results.size(); ++i) {
    const DistanceResult found =
        distance(*results[i], Motion{}, *shape, Motion::resting(shift(2.5 + static_cast<double>(i))));
    EXPECT_NEAR(found.upper, 0.5, 0.02);
  }
}

TEST(RefitShape, RefusesWhatDoesNotFit) {
  const ShapePtr cube = make_shape(shapes::cube(1));
  const auto error_of = [](const Shape& shape, const Vertices& vertices) -> std::string {
    try {
      refit_shape(shape, vertices);
    } catch (const Error& error) {
      return error.what();
    }
    return "none";
  };
  Vertices vertices = shapes::cube(1).vertices;
  EXPECT_EQ(error_of(*cube, vertices), "none");
  EXPECT_EQ(error_of(*cube, vertices.topRows(7)), "refit: 7 vertices for a mesh of 8");
  vertices(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error_of(*cube, vertices), "refit: vertex 3 is not finite");
  vertices(3, 1) = 1e38;
  EXPECT_EQ(error_of(*cube, vertices), "refit: vertex 3 is too large for float32");
  const CompoundPart part{.shape = cube};
  EXPECT_EQ(error_of(*make_compound({&part, 1}), shapes::cube(1).vertices),
            "refit: a compound; refit its parts and make it anew");
  CageHierarchy cages;
  cages.levels.push_back({shapes::cube(1), {}});
  EXPECT_EQ(error_of(*make_shape(cages), shapes::cube(1).vertices), "refit: the shape has no fine mesh");
}

}  // namespace
}  // namespace encage::test
