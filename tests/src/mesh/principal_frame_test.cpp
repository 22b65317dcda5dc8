// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/mesh/principal_frame.h"

#include "oracles/meshes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace encage {
namespace {

double largest(const Eigen::Matrix3d& m) { return m.cwiseAbs().maxCoeff(); }

TEST(PrincipalFrames, RebuildTheTensor) {
  shapes::Random random(5);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d imaginary = random.point(1);
    const Eigen::Quaterniond turn(random(-1, 1), imaginary.x(), imaginary.y(), imaginary.z());
    const Eigen::Matrix3d r = turn.normalized().toRotationMatrix();
    Eigen::Vector3d values = random.point(3);
    if (i % 3 == 0) values[1] = values[0];
    if (i % 7 == 0) values[2] *= 1e-9;
    const Eigen::Matrix3d a = r * values.asDiagonal() * r.transpose();
    const PrincipalFrame frame = principal_frame(a);
    EXPECT_LT(largest(frame.axes.transpose() * frame.axes - Eigen::Matrix3d::Identity()), 1e-14);
    EXPECT_GT(frame.axes.determinant(), 0);
    EXPECT_LE(frame.values[0], frame.values[1]);
    EXPECT_LE(frame.values[1], frame.values[2]);
    const Eigen::Matrix3d again = frame.axes * frame.values.asDiagonal() * frame.axes.transpose();
    EXPECT_LT(largest(again - a), 1e-14 * 3);
  }
  EXPECT_EQ(principal_frame(Eigen::Matrix3d::Zero()).values, Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace encage
