// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/decimate.h"
#include "cagegen/decimate/self_contact.h"
#include "tests/cagegen/decimate/shapes.h"

namespace encage::makers {
namespace {

constexpr double gap = 1e-4;

/// Untangled, with the same triangles, and moved by less than `most` on average.
void expect_untangled(const TriangleMesh& mesh, double most) {
  ASSERT_FALSE(self_contacts(mesh, gap).empty()) << "nothing to do";
  const auto clean = untangle(mesh, gap);
  ASSERT_TRUE(clean);
  EXPECT_EQ(clean->triangles, mesh.triangles);
  EXPECT_EQ(clean->vertices, shapes::rounded(*clean).vertices);
  EXPECT_TRUE(self_contacts(*clean, gap).empty());
  EXPECT_TRUE(shapes::embedded(*clean));
  EXPECT_LT((clean->vertices - mesh.vertices).rowwise().norm().mean(), most);
  EXPECT_EQ(untangle(mesh, gap)->vertices, clean->vertices) << "the same bytes each time";
}

TEST(Untangle, LeavesCleanMeshesAlone) {
  const TriangleMesh mesh = shapes::rounded(shapes::torus(1, 0.4, 24, 12));
  const auto clean = untangle(mesh, gap);
  ASSERT_TRUE(clean);
  EXPECT_EQ(clean->vertices, mesh.vertices);
}

TEST(Untangle, StrandsPushedThroughEachOther) {
  // Linked rings: one tube moves into the other from inside.
  const TriangleMesh along = shapes::torus(1, 0.2, 32, 12);
  TriangleMesh across = along;
  across.vertices.col(1).swap(across.vertices.col(2));
  across.vertices.col(1) *= -1;
  for (const double overlap : {0.0, 0.01, 0.05}) {
    expect_untangled(shapes::joined(along, shapes::moved(across, {1.6 + overlap, 0, 0})), 0.02);
  }
}

TEST(Untangle, PlatesTurnedInsideOut) {
  // The middle of the upper side lies below the lower side: it has to come up again, and nothing to be thinned.
  TriangleMesh plate = shapes::sphere(4);
  plate.vertices.col(2) *= 0.05;
  for (std::int64_t v = 0; v < plate.vertices.rows(); ++v) {
    if (plate.vertices(v, 2) > 0 && plate.vertices.row(v).norm() < 0.3) plate.vertices(v, 2) -= 0.11;
  }
  expect_untangled(plate, 0.02);
}

TEST(Untangle, FoldedVertex) {
  TriangleMesh fold = shapes::torus(1, 0.4, 32, 16);
  fold.vertices.row(40) = 2 * fold.vertices.row(60) - fold.vertices.row(40);
  expect_untangled(fold, 0.02);
  TriangleMesh flat = shapes::sphere(3);
  flat.vertices.row(5) = flat.vertices.row(flat.triangles(3, 1));
  expect_untangled(flat, 0.05);
}

TEST(Untangle, OnlyAroundTheContact) {
  const TriangleMesh torus = shapes::rounded(shapes::torus(1, 0.2, 48, 12));
  TriangleMesh fold = torus;
  fold.vertices.row(40) = 2 * torus.vertices.row(60) - torus.vertices.row(40);
  const auto clean = untangle(fold, gap);
  ASSERT_TRUE(clean);
  for (std::int64_t v = 0; v < fold.vertices.rows(); ++v) {
    if (torus.vertices(v, 0) < 0) {
      EXPECT_EQ(clean->vertices.row(v), torus.vertices.row(v));
    }
  }
}

TEST(Untangle, RefusesWhatIntersectsThroughout) {
  EXPECT_FALSE(untangle(shapes::joined(shapes::sphere(3), shapes::moved(shapes::sphere(3), {0.01, 0, 0})), gap));
  EXPECT_FALSE(untangle(shapes::tetrahedron(1), 0.5 * gap) == std::nullopt) << "it has no contact";
  EXPECT_FALSE(untangle(shapes::cube(1), 10)) << "a gap larger than the mesh";
}

}  // namespace
}  // namespace encage::makers
