// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/stress/quality.h"
#include "bench/stress/report.h"
#include "bench/stress/runs.h"
#include "oracles/meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace encage::stress {
namespace {

TEST(Quality, OfKnownShapes) {
  const Quality cube = quality(shapes::cube(1));
  EXPECT_NEAR(cube.smallest_angle, 45, 1e-9);
  EXPECT_NEAR(cube.low_angle, 45, 1e-9);
  EXPECT_EQ(cube.folds, 0);
  EXPECT_GE(cube.highest_valence, 4);
  EXPECT_LE(cube.highest_valence, 6);

  // A blade: its long edges on two sides are sharper than 20 degrees. A dent as sharp as that is no fold.
  const TriangleMesh blade =
      shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0.1}, {0.5, 1, -0.1}}, {{0, 1, 2}, {1, 0, 3}, {1, 3, 2}, {0, 2, 3}});
  EXPECT_EQ(quality(blade).folds, 1);
  TriangleMesh inside_out = blade;
  inside_out.triangles.col(0).swap(inside_out.triangles.col(1));
  EXPECT_EQ(quality(inside_out).folds, 0);
}

TEST(Noise, StaysWithinItsAmplitude) {
  const TriangleMesh sphere = shapes::sphere(3);
  const TriangleMesh noisy = with_noise(sphere, 0.01);
  const Eigen::VectorXd moved = (noisy.vertices - sphere.vertices).rowwise().norm();
  EXPECT_LE(moved.maxCoeff(), 0.01);
  EXPECT_GT(moved.maxCoeff(), 0.009);
  EXPECT_GT(moved.mean(), 0.004);
  EXPECT_EQ(with_noise(sphere, 0.01).vertices, noisy.vertices) << "always the same";
}

TEST(StressRuns, AskForFewerFacesFromLayerToLayer) {
  EXPECT_GE(job_names().size(), 8u);
  for (const Job& job : all_jobs()) {
    SCOPED_TRACE(job.title);
    const std::vector<std::int64_t>& faces = job.options.faces;
    ASSERT_FALSE(faces.empty());
    EXPECT_TRUE(std::is_sorted(faces.rbegin(), faces.rend()));
    EXPECT_EQ(std::adjacent_find(faces.begin(), faces.end()), faces.end());
    EXPECT_TRUE(!job.model.empty() || job.make);
  }
}

TEST(StressRuns, MeasureEveryLayer) {
  Job job;
  job.name = "sphere";
  job.title = "A sphere";
  job.make = [](const TriangleMesh&) { return shapes::sphere(2); };
  job.options.faces = {60, 30, 20};
  job.options.method = BakeMethod::collapse;
  job.beside_single = true;
  const Outcome outcome = run(job, {}, 1, {});
  EXPECT_EQ(outcome.failure, "");
  ASSERT_EQ(outcome.layers.size(), 3u);
  double ratio = 1;
  for (const Layer& layer : outcome.layers) {
    EXPECT_GT(layer.excess, 0);
    ratio *= 1 + layer.excess;
    EXPECT_NEAR(*layer.volume_ratio, ratio, 1e-9);
    ASSERT_TRUE(layer.single_excess);
    EXPECT_GT(*layer.single_excess, 0);
    EXPECT_GT(layer.quality.smallest_angle, 0);
  }
  const std::string table = to_markdown(job, outcome);
  EXPECT_NE(table.find("## A sphere"), std::string::npos);
  EXPECT_NE(table.find("single cage's: "), std::string::npos);
  const nlohmann::ordered_json json = to_json(job, outcome);
  EXPECT_EQ(json.at("layers").size(), 3u);
  EXPECT_TRUE(json.at("failure").is_null());
}

TEST(StressRuns, SayWhatIsMissing) {
  Job job;
  job.name = "flat";
  job.make = [](const TriangleMesh&) { return shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}); };
  job.options.faces = {4};
  job.options.min_clearance = 1e9;
  const Outcome outcome = run(job, {}, 1, {});
  EXPECT_TRUE(outcome.layers.empty());
  EXPECT_NE(outcome.failure, "");
  EXPECT_NE(to_markdown(job, outcome).find("Not made: "), std::string::npos);
}

}  // namespace
}  // namespace encage::stress
