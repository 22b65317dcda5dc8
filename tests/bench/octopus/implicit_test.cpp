// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/implicit.h"

#include "bench/octopus/octopus_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace encage::octopus {
namespace {

Eigen::Vector3d random_point(std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-1.2, 1.2);
  const double x = coordinate(random), y = coordinate(random);
  return {x, y, coordinate(random)};
}

TEST(Rod, IsTheUnionOfItsSpheres) {
  const Eigen::Vector3d a(0.1, -0.2, 0.3), b(0.5, 0.4, -0.1);
  const Rod rod(a, b, 0.3, 0.1);
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d p = random_point(random);
    double least = 1e9;
    for (int k = 0; k <= 4000; ++k) {
      const double t = k / 4000.0;
      least = std::min(least, (p - a - t * (b - a)).norm() - (0.3 - 0.2 * t));
    }
    EXPECT_NEAR(rod.value(p), least, 1e-6);
    EXPECT_LE(rod.value(p), least + 1e-12);
    EXPECT_EQ(rod.value(p), rod.sample(p).value);
  }
}

TEST(ImplicitSurface, GradientsAreDerivatives) {
  const ImplicitSurface shape = octopus_shape(0.01);
  const auto parts = shape.all_parts();
  std::mt19937 random(2);
  int bad = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p = random_point(random);
    const Eigen::Vector3d gradient = shape.sample(p, parts).gradient;
    Eigen::Vector3d numeric;
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k);
      numeric[k] = (shape.value(p + step, parts) - shape.value(p - step, parts)) / (2 * h);
    }
    bad += (gradient - numeric).norm() > 1e-4;
    EXPECT_LE(gradient.norm(), 1 + 1e-12);
  }
  EXPECT_LE(bad, 3) << "creases are few";
}

TEST(ImplicitSurface, RelevantPartsDecideInsideTheirBall) {
  const ImplicitSurface shape = octopus_shape(0.01);
  const auto all = shape.all_parts();
  std::mt19937 random(3);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d centre = random_point(random);
    const double radius = 0.05;
    const auto some = shape.relevant(all, centre, radius);
    for (int k = 0; k < 20; ++k) {
      const Eigen::Vector3d p = centre + radius * random_point(random).normalized();
      EXPECT_EQ(shape.value(p, some), shape.value(p, all));
      EXPECT_EQ(shape.sample(p, some).value, shape.value(p, some));
    }
  }
}

}  // namespace
}  // namespace encage::octopus
