// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/union_surface.h"

#include "cagegen/certify/certify.h"
#include "oracles/meshes.h"
#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>
#include <encage/error.h>

#include <gtest/gtest.h>

#include <array>
#include <optional>

namespace encage {
namespace {

using shapes::joined;
using shapes::moved;
using shapes::scaled;
using shapes::sphere;
using test::box;
using test::inside_out;

std::optional<TriangleMesh> united(const TriangleMesh& mesh) {
  return io::union_surface(sanitize(mesh).clean, [] {});
}

TEST(UnionSurface, EnclosesWhatThePartsEnclose) {
  const auto cube = [](double x) { return box({x, x, x}, {x + 1, x + 1, x + 1}); };
  const TriangleMesh three = joined(joined(cube(0), cube(0.5)), cube(0.75));
  const auto surface = united(three);
  ASSERT_TRUE(surface);
  EXPECT_TRUE(certify_alone(*surface).holds);
  EXPECT_NEAR(signed_volume(*surface), 3 - 0.125 - 0.75 * 0.75 * 0.75, 1e-12);
}

TEST(UnionSurface, UnitesManyPartsAndCanBeStopped) {
  // A chain of boxes, each overlapping the next by a tenth; one is left over in most rounds.
  TriangleMesh boxes = box({0, 0, 0}, {1, 1, 1});
  constexpr int count = 11;
  for (int i = 1; i < count; ++i) boxes = joined(boxes, box({0.9 * i, 0.01 * i, 0}, {0.9 * i + 1, 1 + 0.01 * i, 1}));
  const auto surface = united(boxes);
  ASSERT_TRUE(surface);
  EXPECT_TRUE(certify_alone(*surface).holds);
  EXPECT_NEAR(signed_volume(*surface), count - (count - 1) * 0.1 * 0.99, 1e-12);

  int checks = 0;
  const auto stop = [&] {
    if (++checks == count + 2) throw Error("stop");
  };
  EXPECT_THROW(io::union_surface(sanitize(boxes).clean, stop), Error);
  EXPECT_EQ(checks, count + 2);
}

TEST(UnionSurface, DropsPartsInsideOthers) {
  const TriangleMesh ball = sphere(3);
  const auto surface = united(joined(ball, scaled(ball, 0.5)));
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->triangles.rows(), ball.triangles.rows());
  EXPECT_NEAR(signed_volume(*surface), signed_volume(ball), 1e-12);
}

TEST(UnionSurface, JoinsPartsThatShareAFace) {
  // The four corners between them are welded: there the surface is no manifold.
  const auto surface = united(joined(box({0, 0, 0}, {1, 1, 1}), box({1, 0.25, 0.25}, {2, 0.75, 0.75})));
  ASSERT_TRUE(surface);
  EXPECT_TRUE(certify_alone(*surface).holds);
  EXPECT_NEAR(signed_volume(*surface), 1.25, 1e-12);
}

TEST(UnionSurface, SurvivesIntersectionsThatAlmostCoincide) {
  // Two bars through a third begin at the same place, but for a rounding.
  TriangleMesh bars = box({0, 0, 0}, {10, 1, 1});
  bars = joined(bars, box({0.1 + 0.2, -1, 0.1}, {3, 2, 0.9}));
  bars = joined(bars, box({0.3, -2, 0.2}, {4, 3, 0.8}));
  const auto surface = united(bars);
  ASSERT_TRUE(surface);
  for (std::int64_t t = 0; t < surface->triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_GT((surface->corner(t, k) - surface->corner(t, (k + 1) % 3)).norm(), 1e-9);
  }
}

TEST(UnionSurface, IsNotMadeWhereNothingOverlaps) {
  const TriangleMesh ball = sphere(3);
  EXPECT_FALSE(united(ball));
  EXPECT_FALSE(united(joined(ball, moved(ball, {5, 0, 0}))));
  // A ring inside another one: their boxes overlap, the rings do not.
  const TriangleMesh ring = shapes::torus(1, 0.2, 24, 12);
  EXPECT_FALSE(united(joined(ring, scaled(ring, 0.5))));
}

TEST(UnionSurface, IsNotMadeOfWhatIsNoSolid) {
  const TriangleMesh ball = sphere(3);
  EXPECT_FALSE(united(joined(ball, inside_out(scaled(ball, 0.5)))));  // a cavity
  // Boxes along one edge: the union is no manifold.
  EXPECT_FALSE(united(joined(box({0, 0, 0}, {1, 1, 1}), box({1, 1, 0}, {2, 2, 1}))));
}

}  // namespace
}  // namespace encage
