// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/intersections.h"

#include "cagegen/certify/certify.h"
#include "oracles/meshes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

namespace encage::zoo {
namespace {

TEST(TouchingTriangles, CountsThem) {
  const TriangleMesh cube = shapes::cube(1);
  EXPECT_EQ(touching_triangles(shapes::cube(2), cube), 0);
  EXPECT_EQ(touching_triangles(shapes::cube(2), shapes::cube(1, {1, 0, 0})), 2) << "a side of two triangles";
  EXPECT_EQ(touching_triangles(cube, cube), 12);
  // A spike through one triangle, far from the origin.
  const Eigen::Vector3d far(1e6, 0, 0);
  const TriangleMesh spike =
      shapes::with_triangle(shapes::cube(1, far), far + Eigen::Vector3d(0, 0.5, 0.2),
                            far + Eigen::Vector3d(3, 0.5, 0.2), far + Eigen::Vector3d(3, 0.5, 0.2));
  EXPECT_EQ(touching_triangles(shapes::cube(2, far), spike), 1);
}

TEST(SelfIntersectingTriangles, CountsThem) {
  EXPECT_EQ(self_intersecting_triangles(shapes::sphere(3)), 0);
  EXPECT_EQ(self_intersecting_triangles(shapes::torus(1, 0.4, 20, 10)), 0);
  const TriangleMesh spike = shapes::tetrahedron(0.3);
  // Its three sides cross one triangle of the cube; its base lies inside.
  const TriangleMesh both = shapes::joined(shapes::cube(1, {0, 0, -1.9}), shapes::moved(spike, {0.3, -0.5, -1}));
  EXPECT_EQ(self_intersecting_triangles(both), 1 + 3);
  EXPECT_EQ(self_intersecting_triangles(shapes::with_triangle(spike, {5, 5, 5}, {6, 6, 6}, {7, 7, 7})), 1);
}

TEST(SelfIntersectingTriangles, SomeIfTheCertificateSaysSo) {
  shapes::Random random(3);
  int refused = 0;
  for (int round = 0; round < 60; ++round) {
    TriangleMesh mesh = shapes::sphere(2);
    for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v)
      mesh.vertices.row(v) += random.point(0.01 * round).transpose();
    const bool holds = certify_alone(mesh).holds;
    refused += !holds;
    EXPECT_EQ(self_intersecting_triangles(mesh) == 0, holds);
  }
  EXPECT_GT(refused, 5);
  EXPECT_LT(refused, 55);
}

}  // namespace
}  // namespace encage::zoo
