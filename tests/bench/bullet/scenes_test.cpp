// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scenes.h"

#include "bench/bullet/contact_method.h"
#include "bench/bullet/scene_meshes.h"
#include "bench/bullet/scene_run.h"

#include <encage/error.h>

#include <gtest/gtest.h>

namespace encage::bullet_bench {
namespace {

std::vector<Eigen::Isometry3d> poses(const std::vector<SceneBody>& bodies) {
  std::vector<Eigen::Isometry3d> result;
  for (const SceneBody& body : bodies) result.push_back(body.pose);
  return result;
}

TEST(Scenes, StartWithoutOverlap) {
  for (const std::string& name : scene_names()) {
    const PreparedScene prepared(make_contact_scene(name, 10'000));
    ASSERT_EQ(prepared.scene.seeds.size(), 3U) << name;
    for (const std::uint64_t seed : prepared.scene.seeds) {
      const std::vector<SceneBody> bodies = prepared.scene.place(seed);
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        const PenetrationProbe& probe = *prepared.probes[bodies[i].mesh];
        for (std::size_t j = 0; j < i; ++j) {
          EXPECT_EQ(penetration(probe, bodies[i].pose, *prepared.probes[bodies[j].mesh], bodies[j].pose), 0)
              << name << ", bodies " << i << " and " << j;
        }
        for (const HalfSpace& plane : prepared.scene.planes) EXPECT_EQ(probe.below(bodies[i].pose, plane), 0) << name;
      }
    }
  }
}

TEST(Scenes, AreTheSameForASeed) {
  const Scene scene = make_contact_scene("bowls");
  const std::vector<SceneBody> a = scene.place(5), b = scene.place(5), c = scene.place(6);
  EXPECT_EQ(a[1].pose.matrix(), b[1].pose.matrix());
  EXPECT_NE(a[1].pose.matrix(), c[1].pose.matrix());
}

TEST(Scenes, PitchesFollowFromTheMeshes) {
  // Facets take 0.67 mm: each ring's inner side is a polygon of 50 sides.
  EXPECT_NEAR(taut_pitch(make_torus()), 2 * (0.24 - 0.07), 7e-4);
  // The wall's vertical thickness where it is steepest, at the rim.
  const double slope = 2 * 0.25 / (0.55 - 0.2);
  EXPECT_NEAR(nested_pitch(make_bowl()), 0.06 * std::sqrt(1 + slope * slope), 0.006);
}

TEST(Scenes, TheChainIsJudgedByItsLength) {
  const Scene scene = make_contact_scene("chain");
  SceneHistory history;
  history.poses.push_back(poses(scene.place(1)));
  const Verdict slack = scene.judge(history);
  EXPECT_FALSE(slack.holds);
  EXPECT_NEAR(slack.value, -100 * 0.005 / taut_pitch(scene.meshes[0]), 0.01);
}

TEST(Scenes, TheNutIsJudgedByItsThread) {
  const Scene scene = make_contact_scene("nut"), held = make_contact_scene("nut_friction");
  const Eigen::Isometry3d start = scene.place(1)[1].pose;
  const auto history = [&](double metres_per_turn) {
    SceneHistory steps;
    for (int k = 0; k <= 120; ++k) {
      const double turns = -k / 60.0;
      const Eigen::Isometry3d turn(Eigen::AngleAxisd(turns * 2 * 3.14159265358979, Eigen::Vector3d::UnitZ()));
      Eigen::Isometry3d pose = start * turn;
      pose.translation().z() += turns * metres_per_turn;
      steps.poses.push_back({Eigen::Isometry3d::Identity(), pose});
    }
    return steps;
  };
  EXPECT_TRUE(scene.judge(history(0.2)).holds);
  EXPECT_NEAR(scene.judge(history(0.204)).value, 2, 1e-6);
  EXPECT_FALSE(scene.judge(history(0.204)).holds);
  EXPECT_FALSE(scene.judge(history(-0.2)).holds);
  EXPECT_FALSE(held.judge(history(0.2)).holds);
}

TEST(Scenes, UnknownNamesAreRefused) {
  EXPECT_THROW(make_contact_scene("pond"), Error);
  EXPECT_THROW(make_contact_method("luck"), Error);
}

TEST(Scenes, ARunIsDeterministic) {
  const PreparedScene prepared(make_contact_scene("chain"));
  const std::unique_ptr<ContactMethod> method = make_contact_method("encage");
  std::vector<std::unique_ptr<MethodShape>> shapes;
  shapes.push_back(method->make_shape(prepared.models[0]));
  const SceneRun a = run_scene(prepared, *method, shapes, 1, {.seconds = 1, .poses_every = 30});
  const SceneRun b = run_scene(prepared, *method, shapes, 1, {.seconds = 1, .poses_every = 30});
  EXPECT_EQ(a.pose_hash, b.pose_hash);
  EXPECT_EQ(a.max_penetration, b.max_penetration);
  ASSERT_EQ(a.poses.size(), 3U);
  EXPECT_EQ(a.poses[2].step, 60);
  EXPECT_EQ(a.start_penetration, 0);
}

}  // namespace
}  // namespace encage::bullet_bench
