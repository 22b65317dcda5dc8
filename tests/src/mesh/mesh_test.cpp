// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/mesh.h>

#include <gtest/gtest.h>

#include <limits>

namespace encage {
namespace {

Eigen::AlignedBox3d around(const Eigen::Vector3d& centre, double half) {
  return {centre.array() - half, centre.array() + half};
}

TEST(LocalOrigin, is_short_in_print_and_within_half_a_diagonal) {
  EXPECT_EQ(local_origin(around({1, -2, 3}, 1)), Eigen::Vector3d::Zero());
  const Eigen::AlignedBox3d box = around({1234.567, 0.25, -98765.4321}, 1);
  const Eigen::Vector3d origin = local_origin(box);
  EXPECT_EQ(origin.y(), 0);
  EXPECT_EQ(origin * 4, (origin * 4).array().round().matrix());
  EXPECT_LE((origin - box.center()).cwiseAbs().maxCoeff(), box.diagonal().norm() / 2);
}

// The sanitizer for undefined behaviour watches: the exponent of 0 is the least int.
TEST(LocalOrigin, of_a_single_point_is_that_point) {
  EXPECT_EQ(local_origin(around({7.3, 0, -1e300}, 0)), Eigen::Vector3d(7.3, 0, -1e300));
  EXPECT_EQ(local_origin(around(Eigen::Vector3d::Zero(), 0)), Eigen::Vector3d::Zero());
}

TEST(LocalOrigin, takes_extents_at_the_ends_of_double) {
  const double tiny = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ(local_origin(around({1, 2, 3}, tiny)), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(local_origin({Eigen::Vector3d(tiny * 100, 0, 0), Eigen::Vector3d(tiny * 101, 0, 0)}).y(), 0);
  EXPECT_TRUE(local_origin(around({0, 0, 0}, 1e300)).isZero());
}

}  // namespace
}  // namespace encage
