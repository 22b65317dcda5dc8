// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/contact/nearest_point.h"

#include "broadphase/shape/shape.h"
#include "oracles/body.h"
#include "oracles/exact_pair.h"
#include "oracles/sampled.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

TEST(SurfaceFeatures, NearestPointsAreThoseOfAllTriangles) {
  shapes::Random random(3);
  for (const Body& body : sample_bodies()) {
    if (!body.has_fine()) continue;
    SCOPED_TRACE(body.sample.name);
    const Surface& fine = body.shape->simple().fine;
    const auto triangles = at_time(body.mesh(), Vector::Zero(), Motion{}, 0);
    const double size = body.diagonal();
    for (int round = 0; round < 100; ++round) {
      const Vector p = random(0, 0.8) * size * random_direction(random);
      Real least = std::numeric_limits<Real>::infinity();
      for (const RealTriangle& t : triangles) least = std::min(least, point_triangle_distance(p.cast<Real>(), t));
      const double distance = static_cast<double>(least);
      SurfacePoint found;
      ASSERT_TRUE(nearest_point(fine, p, 10 * size, found));
      EXPECT_NEAR(found.distance, distance, 1e-12 * size);
      EXPECT_NEAR((found.point - p).norm(), distance, 1e-12 * size);
      EXPECT_LT(static_cast<double>(point_triangle_distance(found.point.cast<Real>(),
                                                            triangles[static_cast<std::size_t>(found.triangle)])),
                1e-12 * size);
      // The reach cuts, and nothing else.
      SurfacePoint again;
      EXPECT_FALSE(nearest_point(fine, p, distance * (1 - 1e-9), again));
      ASSERT_TRUE(nearest_point(fine, p, distance * (1 + 1e-9), again));
      EXPECT_EQ(again.triangle, found.triangle);
    }
  }
}

TEST(SurfaceFeatures, NormalsTellInsideFromOutside) {
  shapes::Random random(4);
  int inside = 0, outside = 0, kinds[3] = {0, 0, 0};
  for (const Body& body : sample_bodies()) {
    if (!body.has_fine() || body.sample.hierarchy.solid != Solid::closed) continue;
    SCOPED_TRACE(body.sample.name);
    const Surface& fine = body.shape->simple().fine;
    if (!fine.closed) continue;
    const SurfaceFeatures features = make_surface_features(fine.mesh, fine.parts);
    const ExactBody exact(Vector::Zero(), body.mesh(), Eigen::Isometry3d::Identity());
    for (int round = 0; round < 60; ++round) {
      const Vector p = random(0, 0.6) * body.diagonal() * random_direction(random);
      SurfacePoint found;
      ASSERT_TRUE(nearest_point(fine, p, std::numeric_limits<double>::infinity(), found));
      if (found.distance < 1e-9 * body.diagonal()) continue;
      const bool is_inside = winding_number(exact, p) != 0;
      const double side = feature_normal(fine, features, found).dot(p - found.point);
      if (winding_number(exact, p) < 0) continue;
      EXPECT_EQ(side < 0, is_inside) << p.transpose();
      ++(is_inside ? inside : outside);
      ++kinds[static_cast<int>(found.kind)];
    }
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
  for (const int count : kinds) EXPECT_GT(count, 20);
}

TEST(SurfaceFeatures, TwinsAreMutual) {
  for (const Body& body : sample_bodies()) {
    if (!body.has_fine()) continue;
    const Surface& fine = body.shape->simple().fine;
    const SurfaceFeatures features = make_surface_features(fine.mesh, fine.parts);
    for (std::size_t side = 0; side < features.twin.size(); ++side) {
      const std::int32_t twin = features.twin[side];
      if (twin < 0) continue;
      EXPECT_EQ(features.twin[static_cast<std::size_t>(twin)], static_cast<std::int32_t>(side));
    }
  }
}

}  // namespace
}  // namespace encage::test
