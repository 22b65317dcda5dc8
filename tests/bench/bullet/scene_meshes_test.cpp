// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_meshes.h"

#include "cagegen/decimate/self_contact.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <set>

namespace encage::bullet_bench {
namespace {

/// Closed, two faces at every edge, outward, without self-intersection.
void expect_sound(const TriangleMesh& mesh, std::int64_t triangles) {
  EXPECT_EQ(mesh.triangles.rows(), triangles);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_GT(signed_volume(mesh), 0);
  std::set<std::array<std::int32_t, 2>> edges;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(edges.insert({mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3)}).second);
    }
  }
  EXPECT_TRUE(makers::self_contacts(mesh, 1e-7).empty());
}

TEST(SceneMeshes, AreSound) {
  expect_sound(make_torus(), 2000);
  for (const double thickness : {0.06, 0.02}) expect_sound(make_bowl({.thickness = thickness}), 5000);
  expect_sound(make_bolt({}, 10, 44, 24), 21'288);
  expect_sound(make_nut({}, 5, 60, 52, 0.5), 16'072);
  expect_sound(make_crate(), 1388);
}

TEST(SceneMeshes, TorusHasTheVolumeOfItsFacets) {
  const Torus fine{0.24, 0.07, 400, 200};
  EXPECT_NEAR(signed_volume(make_torus(fine)), 2 * 9.8696044 * 0.24 * 0.07 * 0.07, 1e-5);
}

TEST(SceneMeshes, BowlIsAsThickAsItSays) {
  const TriangleMesh bowl = make_bowl({.thickness = 0.02});
  EXPECT_NEAR(bounds(bowl).min().z(), 0, 1e-9);
  double floor = 1;  // the lowest vertex of the inner surface on the axis
  for (std::int32_t v = 0; v < bowl.vertices.rows(); ++v) {
    const Eigen::Vector3d p = bowl.vertex(v);
    if (p.head<2>().norm() < 1e-9 && p.z() > 1e-9) floor = std::min(floor, p.z());
  }
  EXPECT_NEAR(floor, 0.02, 1e-7);
}

}  // namespace
}  // namespace encage::bullet_bench
