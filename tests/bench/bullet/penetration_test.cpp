// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/penetration.h"

#include "bench/bullet/scene_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace encage::bullet_bench {
namespace {

Eigen::Isometry3d at(double x, double y, double z) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

TEST(Penetration, OfRingsThatLieOnEachOther) {
  const PenetrationProbe ring(make_torus());
  // The tubes' highest and lowest circles are rings of vertices.
  EXPECT_EQ(penetration(ring, at(0, 0, 0), ring, at(0, 0, 0.1401)), 0);
  // In an overlap of 4 mm a vertex is near the middle of a facet of the other tube, which lies inside the circle.
  EXPECT_NEAR(penetration(ring, at(0, 0, 0), ring, at(0, 0, 0.136)), 0.004, 2e-4);
  EXPECT_EQ(penetration(ring, at(0, 0, 0), ring, at(3, 0, 0)), 0);
}

TEST(Penetration, IsTheSameBothWays) {
  const PenetrationProbe ring(make_torus()), crate(make_crate());
  for (const double x : {0.1, 0.3, 0.5}) {
    const double depth = penetration(ring, at(x, 0.05, 0.3), crate, at(0, 0, 0));
    EXPECT_DOUBLE_EQ(penetration(crate, at(0, 0, 0), ring, at(x, 0.05, 0.3)), depth);
    EXPECT_GT(depth, 0);
  }
}

TEST(Penetration, OfWideFacesWithoutVerticesInside) {
  // Walls of crates that cross: no vertex of one is inside the other, but samples of their faces are.
  const PenetrationProbe crate(make_crate());
  const Eigen::Isometry3d turned = at(0.31, 0.17, 0.2) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
  EXPECT_GT(penetration(crate, at(0, 0, 0), crate, turned), 0.005);
}

TEST(Penetration, AgreesWithAllSamplesAgainstAPlane) {
  const TriangleMesh mesh = make_torus();
  const PenetrationProbe ring(mesh);
  const HalfSpace floor{Eigen::Vector3d::UnitZ(), -0.05};
  const Eigen::Isometry3d pose = at(0.1, 0.2, 0) * Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized());
  double deepest = 0;
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) {
    deepest = std::max(deepest, floor.offset - (pose * mesh.vertex(v)).z());
  }
  EXPECT_DOUBLE_EQ(ring.below(pose, floor), deepest);
  EXPECT_EQ(ring.below(at(0, 0, 0.05), floor), 0);
}

}  // namespace
}  // namespace encage::bullet_bench
