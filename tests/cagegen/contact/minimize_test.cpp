// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/contact/minimize.h"

#include <encage/bake.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "cagegen/collapse/collapse.h"
#include "cagegen/collapse/starts.h"
#include "tests/cagegen/geometry/shapes.h"

namespace encage::makers {
namespace {

constexpr double kClearance = 1e-4;

ContactOptions options(
    int threads, std::function<void()> check = [] {}) {
  return {kClearance, kClearance, threads, std::move(check)};
}

void expect_shrinks(const TriangleMesh& solid, const TriangleMesh& cage, double most) {
  const Obstacle obstacle(solid);
  ASSERT_TRUE(clear(obstacle, cage, kClearance));
  const TriangleMesh first = shrink(obstacle, cage, options(1));
  const CertifyResult proof = certify(solid, Solid::closed, first);
  ASSERT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, 0.999 * kClearance);
  EXPECT_LE(signed_volume(first), signed_volume(cage));
  EXPECT_LE(signed_volume(first), most);
  EXPECT_EQ(first.triangles, cage.triangles);
  EXPECT_EQ(first.vertices, shapes::rounded(first).vertices);
  for (const int threads : {2, 3}) EXPECT_EQ(shrink(obstacle, cage, options(threads)).vertices, first.vertices);
}

TriangleMesh inflated(const TriangleMesh& solid, double height) {
  const auto cage = offset_start(Obstacle(solid), solid, height, false, kClearance);
  EXPECT_TRUE(cage);
  return cage.value_or(solid);
}

TEST(Shrink, ComesBackToTheSurface) {
  const TriangleMesh sphere = shapes::sphere(3);
  expect_shrinks(sphere, inflated(sphere, 0.05), 1.02 * signed_volume(sphere));
  const TriangleMesh torus = shapes::torus(1, 0.3, 24, 12);
  expect_shrinks(torus, inflated(torus, 0.05), 1.1 * signed_volume(torus));
}

TEST(Shrink, CoarseCages) {
  const TriangleMesh torus = shapes::torus(1, 0.35, 40, 20);
  const Obstacle obstacle(torus);
  EditorOptions options;
  options.clearance = options.self_clearance = kClearance;
  CageEditor editor(obstacle, inflated(torus, 0.01), options);
  CollapseLimits limits;
  limits.faces = 320;
  ASSERT_TRUE(collapse_edges(editor, limits));
  const TriangleMesh cage = editor.extract();
  expect_shrinks(torus, cage, signed_volume(cage) * 0.9999);
}

TEST(Shrink, PartsOfTheCageKeepTheirDistance) {
  // Two cubes side by side, their cages nearly touching; and one cage through which a hole is left.
  const TriangleMesh solid = shapes::joined(shapes::cube(1), shapes::cube(1, {2.5, 0, 0}));
  const TriangleMesh cage = shapes::rounded(shapes::joined(shapes::cube(1.24), shapes::cube(1.24, {2.5, 0, 0})));
  expect_shrinks(solid, cage, 1.1 * signed_volume(solid));
}

TEST(Shrink, CheckMayStopIt) {
  const TriangleMesh sphere = shapes::sphere(2);
  const TriangleMesh cage = inflated(sphere, 0.05);
  const auto stop = [] { throw std::runtime_error("stop"); };
  EXPECT_THROW(shrink(Obstacle(sphere), cage, options(2, stop)), std::runtime_error);
}

}  // namespace
}  // namespace encage::makers
