// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/decimate/edge_collapse.h"

#include "cagegen/decimate/self_contact.h"
#include "tests/cagegen/decimate/shapes.h"

#include <encage/error.h>

namespace encage::makers {
namespace {

constexpr Decimation decimations[] = {Decimation::regular, Decimation::adaptive};

TEST(CollapseEdges, KeepsTheTopologyAndReachesTheCount) {
  const TriangleMesh sphere = shapes::bumpy_sphere(4, 1, 0.02);
  const TriangleMesh torus = shapes::torus(1, 0.4, 48, 24);
  for (const Decimation kind : decimations) {
    for (const std::optional<double> gap : {std::optional<double>(), std::optional<double>(1e-4)}) {
      for (const std::int64_t faces : {601, 100}) {
        const TriangleMesh coarse = collapse_edges(sphere, faces, kind, gap, [] {});
        EXPECT_EQ(coarse.triangles.rows(), faces / 2 * 2);
        shapes::expect_manifold(coarse, 0, 1);
        EXPECT_NEAR(signed_volume(coarse), signed_volume(sphere), 0.1 * signed_volume(sphere));
        const TriangleMesh ring = collapse_edges(torus, faces, kind, gap, [] {});
        EXPECT_EQ(ring.triangles.rows(), faces / 2 * 2);
        shapes::expect_manifold(ring, 1, 1);
        EXPECT_NEAR(signed_volume(ring), signed_volume(torus), 0.1 * signed_volume(torus));
      }
    }
  }
}

TEST(CollapseEdges, StopsWhereTheTopologyForbidsMore) {
  const TriangleMesh two = shapes::joined(shapes::sphere(2), shapes::sphere(1));
  for (const Decimation kind : decimations) {
    const TriangleMesh coarse = collapse_edges(shapes::joined(two, shapes::torus(5, 1, 20, 10)), 4, kind, {}, [] {});
    EXPECT_GE(coarse.triangles.rows(), 4 + 4 + 14) << "two tetrahedra and Moebius' torus";
    EXPECT_LT(coarse.triangles.rows(), 60);
    shapes::expect_manifold(coarse, 1, 3);
  }
}

TEST(CollapseEdges, WithAGapNeverIntersectsItself) {
  // Shells thinner than the chords of so few triangles are deep.
  int plain_fails = 0;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const TriangleMesh ball = shapes::bumpy_sphere(4, seed, 0.01);
    const TriangleMesh shell = shapes::joined(ball, shapes::flipped(shapes::scaled(ball, 0.9)));
    ASSERT_TRUE(shapes::embedded(shell));
    for (const Decimation kind : decimations) {
      if (!shapes::embedded(collapse_edges(shell, 80, kind, {}, [] {}))) ++plain_fails;
      const TriangleMesh guarded = collapse_edges(shell, 80, kind, 1e-4, [] {});
      EXPECT_TRUE(shapes::embedded(guarded));
      EXPECT_TRUE(self_contacts(guarded, 1e-4).empty());
      EXPECT_LE(guarded.triangles.rows(), 160);
      shapes::expect_manifold(guarded, 0, 2);
    }
  }
  EXPECT_GE(plain_fails, 3) << "the shapes must be hard";
}

TEST(CollapseEdges, TheSameFarFromTheOrigin) {
  TriangleMesh near = shapes::bumpy_sphere(3, 8);
  near.vertices = (near.vertices * 1048576).array().round().matrix() / 1048576;  // moving it is exact
  for (const Decimation kind : decimations) {
    const TriangleMesh coarse = collapse_edges(near, 100, kind, {}, [] {});
    const TriangleMesh far = collapse_edges(shapes::moved(near, {1024, -4096, 512}), 100, kind, {}, [] {});
    EXPECT_TRUE(far.triangles == coarse.triangles);
    EXPECT_LT((shapes::moved(far, {-1024, 4096, -512}).vertices - coarse.vertices).norm(), 1e-6);
  }
}

TEST(CollapseEdges, TheSameBytesEachTime) {
  const TriangleMesh mesh = shapes::bumpy_sphere(4, 3);
  for (const Decimation kind : decimations) {
    for (const std::optional<double> gap : {std::optional<double>(), std::optional<double>(1e-4)}) {
      const TriangleMesh first = collapse_edges(mesh, 200, kind, gap, [] {});
      const TriangleMesh second = collapse_edges(mesh, 200, kind, gap, [] {});
      EXPECT_EQ(first.vertices, second.vertices);
      EXPECT_EQ(first.triangles, second.triangles);
    }
  }
}

TEST(CollapseEdges, CanBeCancelled) {
  int calls = 0;
  const auto cancel = [&] {
    if (++calls == 5) throw Cancelled();
  };
  EXPECT_THROW(collapse_edges(shapes::sphere(4), 100, Decimation::regular, {}, cancel), Cancelled);
  EXPECT_EQ(calls, 5);
}

TEST(CollapseEdges, RefusesWhatIsNoClosedManifold) {
  TriangleMesh open = shapes::sphere(2);
  open.triangles.conservativeResize(100, 3);
  TriangleMesh twice = shapes::joined(shapes::cube(1), shapes::cube(1));
  twice.triangles.row(13) = twice.triangles.row(1);
  for (const TriangleMesh& mesh : {open, twice}) {
    EXPECT_THROW(collapse_edges(mesh, 50, Decimation::regular, {}, [] {}), Error);
  }
}

}  // namespace
}  // namespace encage::makers
