// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/shape/shape.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

namespace encage {
namespace {

TriangleMesh tetrahedron(double size) {
  TriangleMesh mesh;
  mesh.vertices.resize(4, 3);
  mesh.vertices << 1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1;
  mesh.vertices *= size;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  return mesh;
}

CageHierarchy hierarchy() {
  CageHierarchy h;
  h.fine = tetrahedron(1);
  h.levels.push_back({tetrahedron(1.5), {}});
  h.levels.push_back({tetrahedron(2), {}});
  return h;
}

std::string message(const std::function<void(CageHierarchy&)>& spoil) {
  CageHierarchy h = hierarchy();
  spoil(h);
  try {
    make_shape(h);
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Shape, CountsItsLevels) {
  const ShapePtr shape = make_shape(hierarchy());
  EXPECT_EQ(level_count(*shape), 2);
  EXPECT_EQ(level_triangles(*shape, 0), 4);
  EXPECT_EQ(shape->simple().fine.parts.size(), 1u);
  EXPECT_TRUE(shape->simple().fine.closed);
  EXPECT_GE(shape->simple().cages[1].radius, 2 * std::sqrt(3.0));
}

TEST(Shape, RefusesMalformedHierarchies) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message([](CageHierarchy&) {}), "accepted");
  EXPECT_EQ(message([](CageHierarchy& h) { h.fine = {}; }), "accepted");
  EXPECT_EQ(message([](CageHierarchy& h) { h.levels.clear(); }), "accepted");
  EXPECT_EQ(message([](CageHierarchy& h) { h.fine = {}, h.levels.clear(); }),
            "hierarchy has neither cages nor a fine mesh");
  EXPECT_EQ(message([](CageHierarchy& h) { h.levels[1].mesh = {}; }), "cage 2: no triangles");
  EXPECT_EQ(message([](CageHierarchy& h) { h.levels[0].mesh.triangles.conservativeResize(3, 3); }),
            "cage 1: not closed");
  EXPECT_EQ(message([](CageHierarchy& h) { h.levels[0].mesh.vertices(2, 1) = nan; }), "cage 1: vertex 2: not finite");
  EXPECT_EQ(message([](CageHierarchy& h) { h.fine.vertices(3, 0) = 0.1; }),
            "fine mesh: vertex 3: 0.10000000000000001 is not exact in float32");
  EXPECT_EQ(message([](CageHierarchy& h) { h.fine.vertices(3, 0) = 0x1p200; }),
            "fine mesh: vertex 3: 1.6069380442589903e+60 is not exact in float32");
  EXPECT_EQ(message([](CageHierarchy& h) { h.fine.triangles(1, 2) = 4; }),
            "fine mesh: triangle 1: index 4 is out of range, there are 4 vertices");
  EXPECT_EQ(message([](CageHierarchy& h) { h.fine.triangles(1, 2) = -1; }),
            "fine mesh: triangle 1: index 4294967295 is out of range, there are 4 vertices");
  // Scaled by as much as a body may be, 1e300 would make boxes that are no numbers.
  for (const double bad : {nan, 1e300, -1.01e150}) {
    EXPECT_EQ(message([&](CageHierarchy& h) { h.origin.y() = bad; }),
              "hierarchy: the origin is not finite or beyond 1e150");
  }
  EXPECT_EQ(message([](CageHierarchy& h) { h.fine_error = -1; }), "hierarchy: fine_error is not a finite distance");
  EXPECT_EQ(message([](CageHierarchy& h) { h.fine_error = nan; }), "hierarchy: fine_error is not a finite distance");
}

}  // namespace
}  // namespace encage
