// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/clean.h"

#include "tests/cagegen/tool/meshes.h"

#include <gtest/gtest.h>

namespace encage::zoo {
namespace {

TriangleMesh both(const TriangleMesh& a, TriangleMesh b, const Eigen::RowVector3d& shift) {
  b.vertices.rowwise() += shift;
  b.triangles.array() += static_cast<std::int32_t>(a.vertices.rows());
  TriangleMesh sum;
  sum.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  sum.vertices << a.vertices, b.vertices;
  sum.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  sum.triangles << a.triangles, b.triangles;
  return sum;
}

const TriangleMesh ring = test::torus(12, 8);

TEST(IsClean, AcceptsManifolds) {
  EXPECT_TRUE(is_clean(ring));
  EXPECT_TRUE(is_clean(both(ring, ring, {3, 0, 0})));
}

TEST(IsClean, RefusesHoles) {
  TriangleMesh open = ring;
  open.triangles.conservativeResize(open.triangles.rows() - 1, 3);
  EXPECT_FALSE(is_clean(open));
  EXPECT_FALSE(is_clean(TriangleMesh{}));
}

TEST(IsClean, RefusesSelfIntersection) { EXPECT_FALSE(is_clean(both(ring, ring, {0.5, 0, 0.01}))); }

TEST(IsClean, RefusesInconsistentOrientation) {
  TriangleMesh mixed = ring;
  mixed.triangles.row(0) = ring.triangles.row(0).reverse();
  EXPECT_FALSE(is_clean(mixed));
}

TEST(IsClean, RefusesAVertexSharedByTwoComponents) {
  TriangleMesh pair = both(ring, ring, {2.6, 0, 0});
  // They touch at x = 1.3, where the first one has its vertex 0.
  Eigen::Index nearest = 0;
  (pair.vertices.bottomRows(ring.vertices.rows()).rowwise() - pair.vertices.row(0)).rowwise().norm().minCoeff(&nearest);
  const auto other = static_cast<std::int32_t>(ring.vertices.rows() + nearest);
  pair.triangles = pair.triangles.unaryExpr([&](std::int32_t v) { return v == other ? 0 : v; }).eval();
  EXPECT_FALSE(is_clean(pair));
}

TEST(IsClean, RefusesDegenerateTriangles) {
  TriangleMesh folded = ring;
  folded.triangles.conservativeResize(folded.triangles.rows() + 1, 3);
  folded.triangles.bottomRows(1) << 0, 1, 1;
  EXPECT_FALSE(is_clean(folded));
}

}  // namespace
}  // namespace encage::zoo
