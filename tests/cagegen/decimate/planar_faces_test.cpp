// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/planar_faces.h"

#include "cagegen/certify/certify.h"
#include "oracles/meshes.h"
#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace encage {
namespace {

constexpr std::int64_t any = std::numeric_limits<std::int64_t>::max();
constexpr double tolerance = 1e-6;

/// Each triangle becomes four, `times` over.
TriangleMesh subdivided(TriangleMesh mesh, int times) {
  for (; times > 0; --times) {
    std::vector<Eigen::RowVector3d> points;
    for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
      const Eigen::RowVector3d a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
      const Eigen::RowVector3d ab = (a + b) / 2, bc = (b + c) / 2, ca = (c + a) / 2;
      for (const auto& p : {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca}) points.push_back(p);
    }
    TriangleMesh finer;
    finer.vertices.resize(static_cast<std::int64_t>(points.size()), 3);
    finer.triangles.resize(static_cast<std::int64_t>(points.size()) / 3, 3);
    for (std::size_t i = 0; i < points.size(); ++i) {
      finer.vertices.row(static_cast<std::int64_t>(i)) = points[i];
      finer.triangles(static_cast<std::int64_t>(i / 3), static_cast<int>(i % 3)) = static_cast<std::int32_t>(i);
    }
    mesh = sanitize(finer).clean;  // welds
  }
  return mesh;
}

void expect_same_solid(const TriangleMesh& merged, const TriangleMesh& mesh) {
  EXPECT_TRUE(certify_alone(merged).holds) << certify_alone(merged).reason;
  EXPECT_NEAR(signed_volume(merged), signed_volume(mesh), 1e-9);
}

TEST(PlanarFaces, ABoxNeedsTwelveTriangles) {
  const TriangleMesh mesh = subdivided(test::box(), 3);
  const auto merged = makers::merge_planar_faces(mesh, tolerance, any);
  ASSERT_TRUE(merged);
  EXPECT_EQ(merged->triangles.rows(), 12);
  EXPECT_EQ(merged->vertices.rows(), 8);
  expect_same_solid(*merged, mesh);
}

TEST(PlanarFaces, KeepsHoles) {
  // A square frame: two of its faces have holes.
  const TriangleMesh frame = shapes::torus(2, 0.5, 4, 4);
  const TriangleMesh mesh = subdivided(frame, 2);
  const auto merged = makers::merge_planar_faces(mesh, tolerance, any);
  ASSERT_TRUE(merged);
  EXPECT_EQ(merged->vertices.rows(), 16);
  EXPECT_EQ(merged->triangles.rows(), 32);
  expect_same_solid(*merged, mesh);
}

TEST(PlanarFaces, LeavesCurvedSurfacesAsTheyAre) {
  const TriangleMesh ball = shapes::sphere(3);
  const auto merged = makers::merge_planar_faces(ball, tolerance, any);
  ASSERT_TRUE(merged);
  EXPECT_EQ(merged->triangles.rows(), ball.triangles.rows());
  expect_same_solid(*merged, ball);
}

TEST(PlanarFaces, GivesNothingAboveTheBudget) {
  const TriangleMesh mesh = subdivided(test::box(), 2);
  EXPECT_TRUE(makers::merge_planar_faces(mesh, tolerance, 12));
  EXPECT_FALSE(makers::merge_planar_faces(mesh, tolerance, 11));
}

}  // namespace
}  // namespace encage
