// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/polygonize.h"

#include <gtest/gtest.h>

#include <cmath>

namespace encage::octopus {
namespace {

ImplicitSurface ball(const Eigen::Vector3d& centre, double radius) {
  return ImplicitSurface({{{Rod(centre, centre, radius, radius)}, 0}});
}

TEST(Polygonize, BallIsABall) {
  const Eigen::Vector3d centre(0.1, -0.05, 0.2);
  const TriangleMesh mesh = polygonize(ball(centre, 0.5), {1.0, 0.1}, 5000, 0.01);
  EXPECT_NEAR(static_cast<double>(mesh.triangles.rows()), 5000, 50);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_EQ(mesh.vertices.rows() - mesh.triangles.rows() / 2, 2) << "Euler's formula";
  for (std::int32_t v = 0; v < mesh.vertices.rows(); ++v) EXPECT_NEAR((mesh.vertex(v) - centre).norm(), 0.5, 1e-9);
  const double volume = 4.0 / 3 * 3.14159265358979 * 0.125;
  EXPECT_NEAR(signed_volume(mesh), volume, 0.003 * volume);
}

TEST(Polygonize, TrianglesAreWellShaped) {
  const TriangleMesh mesh = polygonize(ball(Eigen::Vector3d(0.013, 0.007, -0.021), 0.6), {1.0, 0.05}, 20000, 0.01);
  double least_sine = 1;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d u = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k);
      const Eigen::Vector3d v = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
      least_sine = std::min(least_sine, u.cross(v).norm() / (u.norm() * v.norm()));
    }
  }
  EXPECT_GT(least_sine, 0.3);
}

TEST(Polygonize, SeparateBallsStaySeparate) {
  const ImplicitSurface two(
      {{{Rod({-0.5, 0, 0}, {-0.5, 0, 0}, 0.3, 0.3)}, 0}, {{Rod({0.5, 0, 0}, {0.5, 0, 0}, 0.2, 0.2)}, 0}});
  const TriangleMesh mesh = polygonize(two, {1.0, 0.1}, 3000, 0.02);
  std::vector<std::int32_t> label;
  EXPECT_EQ(triangle_components(mesh, label), 2);
  EXPECT_TRUE(is_closed(mesh));
}

}  // namespace
}  // namespace encage::octopus
