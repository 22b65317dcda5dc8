// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/baselines.h"

#include "bench/zoo/plain_methods.h"
#include "oracles/meshes.h"

#include <gtest/gtest.h>

namespace encage::zoo {
namespace {

TEST(Baselines, EncloseASphere) {
  const SourceMesh source = sanitize(shapes::sphere(4));
  const std::vector<BaselineResult> results = run_baselines(source, 300);
  ASSERT_EQ(results.size(), 3u);
  EXPECT_EQ(results[0].name, "alpha wrap");
  EXPECT_EQ(results[1].name, "progressive hull");
  EXPECT_EQ(results[2].name, "offset contour");
  for (const BaselineResult& result : results) {
    EXPECT_TRUE(result.certified) << result.name << ": " << result.error;
    EXPECT_EQ(result.error, "") << result.name;
    EXPECT_EQ(result.hits, 0) << result.name;
    EXPECT_EQ(result.self_hits, 0) << result.name;
    EXPECT_LE(result.faces, 300) << result.name;
    EXPECT_GT(result.faces, 40) << result.name;
    ASSERT_TRUE(result.volume_ratio) << result.name;
    EXPECT_GT(*result.volume_ratio, 1) << result.name;
    EXPECT_LT(*result.volume_ratio, 1.4) << result.name;
    EXPECT_GT(result.cpu_seconds, 0) << result.name;
  }
  EXPECT_LT(*results[1].volume_ratio, 1.1) << "on convex input nothing is tighter than a hull";
}

TEST(Baselines, TheHullCutsThroughOtherParts) {
  // Two bowls, one in the other: their hulls know nothing of each other.
  TriangleMesh bowl = shapes::joined(shapes::sphere(4), shapes::flipped(shapes::scaled(shapes::sphere(4), 0.9)));
  const SourceMesh source = sanitize(shapes::joined(bowl, shapes::scaled(shapes::sphere(4), 0.88)));
  const BaselineResult hull = progressive_hull(source, 90);
  EXPECT_FALSE(hull.certified);
  EXPECT_GT(hull.self_hits, 0);
  EXPECT_NE(hull.error, "");
  EXPECT_LE(hull.faces, 90);
}

TEST(Baselines, OpenSourcesHaveNoRatio) {
  TriangleMesh flat = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
  const SourceMesh source = sanitize(flat);
  ASSERT_EQ(source.solid, Solid::surface_only);
  const std::vector<BaselineResult> results = run_baselines(source, 200);
  EXPECT_EQ(results[1].error, "the source is not a closed manifold");
  EXPECT_EQ(results[1].faces, 0);
  for (const BaselineResult& result : results) {
    EXPECT_FALSE(result.volume_ratio) << result.name;
    EXPECT_EQ(result.certified, result.name != "progressive hull") << result.name << ": " << result.error;
  }
}

TEST(Baselines, SayWhatCannotBeDone) {
  const SourceMesh source = sanitize(shapes::torus(1, 0.4, 30, 16));
  for (const BaselineResult& result : run_baselines(source, 3)) {
    EXPECT_FALSE(result.certified) << result.name;
    EXPECT_NE(result.error, "") << result.name;
  }
}

TEST(DistanceGrid, ContoursAtTheDistance) {
  const TriangleMesh sphere = shapes::sphere(4);
  for (const bool closed : {true, false}) {
    const DistanceGrid grid(sphere, closed, 40, 0.5);
    for (const double distance : {0.2, 0.5}) {
      const TriangleMesh contour = grid.contour(distance);
      EXPECT_TRUE(is_closed(contour));
      EXPECT_EQ(contour.vertices.rows() - contour.triangles.rows() / 2, 2) << "the outer one of two surfaces";
      for (const auto& v : contour.vertices.rowwise()) EXPECT_NEAR(v.norm(), 1 + distance, 0.02);
      EXPECT_GT(signed_volume(contour), 0);
    }
  }
}

}  // namespace
}  // namespace encage::zoo
