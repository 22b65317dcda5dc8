// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/connectivity.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

namespace encage::proof {
namespace {

TEST(Connectivity, SphereAndTorus) {
  const Connectivity sphere = connectivity(shapes::sphere(2));
  EXPECT_EQ(sphere.defect, "");
  EXPECT_TRUE(sphere.closed);
  EXPECT_EQ(sphere.genus, 0);
  const Connectivity torus = connectivity(shapes::torus(2, 0.5, 9, 5));
  EXPECT_EQ(torus.defect, "");
  EXPECT_EQ(torus.genus, 1);
}

TEST(Connectivity, GenusIsSummedOverComponents) {
  const TriangleMesh torus = shapes::torus(2, 0.5, 9, 5);
  const Connectivity c = connectivity(shapes::joined(shapes::joined(torus, torus), shapes::cube(1)));
  EXPECT_EQ(c.component_count, 3);
  EXPECT_EQ(c.genus, 2);
}

TEST(Connectivity, UnusedVerticesDoNotCount) {
  TriangleMesh m = shapes::cube(1);
  m.vertices.conservativeResize(20, 3);
  EXPECT_EQ(connectivity(m).defect, "");
  EXPECT_EQ(connectivity(m).genus, 0);
}

TEST(Connectivity, BoundaryEdge) {
  TriangleMesh m = shapes::tetrahedron(1);
  m.triangles.conservativeResize(3, 3);  // the triangle 0-3-2 is gone
  const Connectivity c = connectivity(m);
  EXPECT_FALSE(c.closed);
  EXPECT_EQ(c.open_edge, "edge 0-2");
  EXPECT_EQ(c.defect, "edge 0-2 of triangle 0 has no other triangle");
}

TEST(Connectivity, TurnedTriangle) {
  TriangleMesh m = shapes::tetrahedron(1);
  std::swap(m.triangles(2, 0), m.triangles(2, 1));
  const Connectivity c = connectivity(m);
  EXPECT_FALSE(c.closed);
  EXPECT_EQ(c.defect, "triangles 0 and 2 run along edge 1-2 in the same direction");
}

TEST(Connectivity, EdgeOfFourTrianglesIsClosedButNoManifold) {
  // Two tetrahedra glued along the edge 0-1.
  const TriangleMesh m =
      shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}},
                   {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 4, 1}, {0, 1, 5}, {1, 4, 5}, {0, 5, 4}});
  const Connectivity c = connectivity(m);
  EXPECT_TRUE(c.closed);
  EXPECT_EQ(c.defect, "edge 0-1 borders 4 triangles");
}

TEST(Connectivity, VertexOfTwoFans) {
  TriangleMesh m = shapes::joined(shapes::tetrahedron(1), shapes::tetrahedron(-1));
  for (Eigen::Index i = 0; i < m.triangles.size(); ++i) {
    if (m.triangles.data()[i] == 4) m.triangles.data()[i] = 0;
  }
  const Connectivity c = connectivity(m);
  EXPECT_TRUE(c.closed);
  EXPECT_EQ(c.component_count, 1);
  EXPECT_EQ(c.defect, "vertex 0 joins several fans of triangles");
}

TEST(Connectivity, RepeatedVertex) {
  TriangleMesh m = shapes::tetrahedron(1);
  m.triangles.conservativeResize(5, 3);
  m.triangles.row(4) << 1, 1, 2;
  const Connectivity c = connectivity(m);
  EXPECT_EQ(c.defect, "triangle 4 uses vertex 1 twice");
  EXPECT_TRUE(c.closed) << "like is_closed(), which does not count such triangles";
  EXPECT_EQ(c.closed, is_closed(m));
}

TEST(Connectivity, AgreesWithIsClosedOnRandomTriangles) {
  shapes::Random random(7);
  int closed = 0;
  for (int round = 0; round < 3000; ++round) {
    TriangleMesh m;
    m.vertices.setZero(4, 3);
    m.triangles.resize(2 + random.integer(4), 3);
    for (Eigen::Index i = 0; i < m.triangles.size(); ++i) m.triangles.data()[i] = random.integer(4);
    const Connectivity c = connectivity(m);
    ASSERT_EQ(c.closed, is_closed(m)) << m.triangles;
    closed += c.closed;
  }
  EXPECT_GT(closed, 100);
  EXPECT_LT(closed, 2900);
}

}  // namespace
}  // namespace encage::proof
