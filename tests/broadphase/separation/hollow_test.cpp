// SPDX-License-Identifier: GPL-3.0-or-later
// Hollow bodies, which are their surface alone, and shapes made of meshes without cages.
#include "oracles/body.h"
#include "oracles/exact_pair.h"
#include "oracles/meshes.h"
#include "oracles/twin_bodies.h"

#include <encage/error.h>
#include <encage/separated.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

bool apart(const ShapePtr& a, const ShapePtr& b, const Pose& pose_b, double margin = 0) {
  return separated(*a, Motion::resting(Pose::Identity()), *b, Motion::resting(pose_b), {.margin = margin}).separated;
}

/// Returns hills and valleys of height 1 over [-n, n]^2, open below.
TriangleMesh terrain(int n) {
  TriangleMesh mesh;
  const int side = 2 * n + 1;
  mesh.vertices.resize(side * side, 3);
  mesh.triangles.resize(8 * n * n, 3);
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double x = i - n, y = j - n;
      mesh.vertices.row(i * side + j) << x, y, std::sin(0.7 * x) * std::cos(0.5 * y);
    }
  }
  int t = 0;
  for (int i = 0; i + 1 < side; ++i) {
    for (int j = 0; j + 1 < side; ++j) {
      const int v = i * side + j;
      mesh.triangles.row(t++) << v, v + side, v + side + 1;
      mesh.triangles.row(t++) << v, v + side + 1, v + 1;
    }
  }
  return mesh;
}

TEST(Hollow, NothingIsInsideAClosedSurface) {
  const TriangleMesh box = shapes::cube(1);
  const ShapePtr small = make_shape(shapes::cube(0.25));
  const ShapePtr solid = make_shape(box), hollow = make_shape(box, {.hollow = true});
  EXPECT_FALSE(apart(solid, small, Pose::Identity()));
  EXPECT_TRUE(apart(hollow, small, Pose::Identity()));
  EXPECT_TRUE(apart(hollow, small, Pose::Identity(), 0.74));
  EXPECT_FALSE(apart(hollow, small, Pose::Identity(), 0.75));
  EXPECT_FALSE(apart(hollow, small, shift(0.75, 0, 0)));
  // The hollow cube still lies in the solid body.
  EXPECT_FALSE(apart(solid, make_shape(shapes::cube(0.25), {.hollow = true}), Pose::Identity()));
}

TEST(Hollow, CagesHoldItAsAnyOtherBody) {
  for (const Sample& sample : sample_shapes(0)) {
    if (sample.name != "box") continue;
    const ShapePtr cages = make_shape(without_fine(sample).hierarchy, {.hollow = true});
    EXPECT_FALSE(apart(cages, make_shape(shapes::cube(0.01)), Pose::Identity()));
  }
}

TEST(Hollow, BodiesInTheValleysOfATerrainAreApartFromIt) {
  const ShapePtr ground = make_shape(terrain(10), {.hollow = true});
  const ShapePtr unknown = make_shape(terrain(10));
  const TriangleMesh cube = shapes::cube(0.2);
  const ShapePtr body = make_shape(cube);
  const ExactBody exact_ground(Vector::Zero(), terrain(10), Pose::Identity());
  TwinRandom random(1);
  int rejected = 0, in_hull = 0;
  for (int i = 0; i < 400; ++i) {
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(random.uniform(0, 3.1), random.direction()).toRotationMatrix();
    pose.translation() = Vector(random.uniform(-9, 9), random.uniform(-9, 9), random.uniform(-1.5, 1.5));
    const double margin = random.coin() ? 0 : random.uniform(0, 0.3);
    const bool apart_from_ground = apart(ground, body, pose, margin);
    EXPECT_EQ(apart_from_ground, !surfaces_meet(exact_ground, {Vector::Zero(), cube, pose}, margin)) << i;
    rejected += apart_from_ground ? 1 : 0;
    in_hull += apart_from_ground && !apart(unknown, body, pose, margin) ? 1 : 0;
  }
  EXPECT_GT(rejected, 100);
  EXPECT_GT(in_hull, 50);
}

TEST(BareMesh, IsSolidWhereNoEdgeIsOpen) {
  const ShapePtr box = make_shape(shapes::moved(shapes::cube(1), Vector(1e7, 0, 0)));
  EXPECT_EQ(level_count(*box), 0);
  const ShapePtr small = make_shape(shapes::cube(0.1));
  EXPECT_FALSE(apart(box, small, shift(1e7, 0, 0)));
  EXPECT_TRUE(apart(box, small, shift(1e7, 0, 1.101)));
  EXPECT_FALSE(apart(box, small, shift(1e7, 0, 1.1)));
}

TEST(BareMesh, BadInputIsNamed) {
  const auto message = [](const TriangleMesh& mesh) -> std::string {
    try {
      make_shape(mesh);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  TriangleMesh mesh = shapes::cube(1);
  mesh.vertices(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message(mesh), "mesh: vertex 3 is not finite");
  mesh = shapes::cube(1);
  mesh.vertices(3, 1) = 1e60;
  EXPECT_EQ(message(mesh), "mesh: vertex 3 has a coordinate of 1e+60, beyond 1e37: choose a larger unit");
  mesh.triangles(2, 0) = 99;
  EXPECT_EQ(message(mesh), "mesh: triangle 2 has vertex 99, of 8");
  EXPECT_EQ(message({}), "mesh: no triangles");
}

}  // namespace
}  // namespace encage::test
