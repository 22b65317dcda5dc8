// SPDX-License-Identifier: GPL-3.0-or-later

#include "oracles/meshes.h"
#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

namespace encage {
namespace {

using shapes::joined;
using shapes::moved;
using shapes::scaled;
using shapes::sphere;
using test::box;
using test::inside_out;

double solid_volume(const TriangleMesh& mesh) { return sanitize(mesh).volume; }

TEST(SolidVolume, IsTheSignedVolumeWhereNothingOverlaps) {
  const TriangleMesh ball = sphere(4), ring = shapes::torus(1, 0.3, 40, 20);
  const TriangleMesh hollow = joined(ball, inside_out(scaled(ball, 0.5)));
  for (const TriangleMesh& mesh : {ball, ring, box(), hollow, joined(ring, moved(ball, {5, 0, 0}))}) {
    const SourceMesh source = sanitize(mesh);
    EXPECT_EQ(source.volume, signed_volume(source.obstacle));
  }
}

TEST(SolidVolume, CountsPartsInsideOthersOnce) {
  const TriangleMesh ball = sphere(5);
  const TriangleMesh nested = joined(joined(ball, scaled(ball, 0.9)), scaled(ball, 0.5));
  EXPECT_NEAR(solid_volume(nested) / signed_volume(ball), 1, 1e-12);
  // A ball in the cavity of a ball: not around the cavity, but in it.
  const TriangleMesh in_cavity = joined(joined(ball, inside_out(scaled(ball, 0.6))), scaled(ball, 0.3));
  EXPECT_NEAR(solid_volume(in_cavity), signed_volume(in_cavity), 1e-12);
}

TEST(SolidVolume, CountsIntersectionsOnce) {
  const auto cube = [](double x) { return box({x, x, x}, {x + 1, x + 1, x + 1}); };
  EXPECT_NEAR(solid_volume(joined(cube(0), cube(0.5))), 2 - 0.125, 4e-3);
  // In one place, and just touching.
  EXPECT_NEAR(solid_volume(joined(cube(0), moved(cube(0), {1e-9, 0, 0}))), 1, 2e-3);
  EXPECT_NEAR(solid_volume(joined(box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1}))), 2, 1e-12);
}

TEST(SolidVolume, CountsWhatIsInsideOut) {
  // A bow tie: the outline of a prism crosses itself, so that one of the halves winds backwards.
  const std::vector<std::array<double, 2>> outline = {{0, 0}, {2, 1}, {2, 0}, {0, 2}};
  std::vector<std::array<double, 3>> vertices;
  for (const double z : {0.0, 1.0}) {
    for (const auto& p : outline) vertices.push_back({p[0], p[1], z});
  }
  std::vector<std::array<std::int32_t, 3>> triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}};
  for (std::int32_t i = 0; i < 4; ++i) {
    const std::int32_t j = (i + 1) % 4;
    triangles.insert(triangles.end(), {{i, j, j + 4}, {i, j + 4, i + 4}});
  }
  TriangleMesh tie = shapes::mesh(vertices, triangles);
  if (signed_volume(tie) < 0) tie = inside_out(tie);
  // The outline crosses itself at (4/3, 2/3): triangles of area 4/3 and 1/3.
  EXPECT_NEAR(signed_volume(tie), 1, 1e-12);
  EXPECT_NEAR(solid_volume(tie), 5.0 / 3, 0.01);
}

TEST(SolidVolume, AnySize) {
  const TriangleMesh ball = sphere(4);
  const TriangleMesh nested = joined(ball, scaled(ball, 0.5));
  for (const double size : {1e-28, 1e36}) {
    EXPECT_NEAR(solid_volume(scaled(nested, size)) / signed_volume(scaled(ball, size)), 1, 1e-3);
  }
}

}  // namespace
}  // namespace encage
