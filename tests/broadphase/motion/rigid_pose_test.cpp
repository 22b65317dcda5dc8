// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/motion/pose.h"
#include "oracles/body.h"
#include "oracles/sampled.h"

#include <encage/error.h>
#include <encage/rigid_pose.h>
#include <encage/separated.h>

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

namespace encage::test {
namespace {

using Matrix = Eigen::Matrix3d;
using MatrixL = Eigen::Matrix<Real, 3, 3>;
using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN(),
                 endless = std::numeric_limits<double>::infinity();

Eigen::Quaternionf random_quaternion(shapes::Random& random) {
  return Eigen::Quaterniond(random_rotation(random, 3.1)).cast<float>();
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

/// Fails if the matrix takes some point farther from where the pose takes it than the deviation says.
void expect_bounded(const MatrixL& matrix, const RigidPose& rigid, shapes::Random& random) {
  const MatrixL difference = matrix - rigid.pose.linear().cast<Real>();
  for (int i = 0; i < 4; ++i) {
    const Point x = random_direction(random).cast<Real>();
    ASSERT_LE((difference * x).norm(), static_cast<Real>(rigid.deviation) * x.norm());
  }
}

TEST(RigidPoses, FloatMatricesBecomeUsable) {
  shapes::Random random(1);
  int usable_before = 0;
  double largest = 0;
  for (int i = 0; i < 10'000; ++i) {
    Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
    matrix.topLeftCorner<3, 3>() = random_quaternion(random).toRotationMatrix();
    matrix.topRightCorner<3, 1>() = random.point(100).cast<float>();
    Pose given;
    given.matrix() = matrix.cast<double>();
    usable_before += is_usable(given) ? 1 : 0;
    const RigidPose rigid = nearest_rigid(matrix);
    ASSERT_TRUE(is_usable(rigid.pose));
    ASSERT_LT(departure_from_rigid(rigid.pose.linear()), 1e-14);
    ASSERT_EQ(rigid.pose.translation(), given.translation());
    expect_bounded(given.linear().cast<Real>(), rigid, random);
    largest = std::max(largest, rigid.deviation);
  }
  EXPECT_EQ(usable_before, 0);
  EXPECT_GT(largest, 1e-8);
  EXPECT_LT(largest, 1e-6);
}

TEST(RigidPoses, AreNearest) {
  shapes::Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const double spread = std::pow(10.0, random(0, 3)), unit = std::pow(10.0, random(-30, 30));
    const Vector stretch(unit, unit * random(1, spread), unit * spread);
    const Matrix r = random_rotation(random, 3.1), axes = random_rotation(random, 3.1);
    const Matrix matrix = r * axes * stretch.asDiagonal() * axes.transpose();
    const RigidPose rigid = nearest_rigid(matrix);
    ASSERT_TRUE(is_usable(rigid.pose));
    ASSERT_EQ(rigid.pose.translation(), Vector::Zero());
    // The polar factor by another way.
    const Eigen::JacobiSVD<Matrix> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    ASSERT_LT((rigid.pose.linear() - svd.matrixU() * svd.matrixV().transpose()).norm(), 1e-13 * spread) << spread;
    ASSERT_LT((rigid.pose.linear() - r).norm(), 1e-13 * spread);
    const Eigen::JacobiSVD<Matrix> difference(matrix - rigid.pose.linear());
    ASSERT_GE(rigid.deviation, difference.singularValues()[0] * (1 - 1e-14));
    ASSERT_LE(rigid.deviation, difference.singularValues()[0] * 1.15);
    expect_bounded(matrix.cast<Real>(), rigid, random);
  }
}

TEST(RigidPoses, OfRigidPosesAreThemselves) {
  shapes::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Pose pose = random_pose(random, 1e6);
    const RigidPose rigid = nearest_rigid(pose.matrix());
    ASSERT_LT(rigid.deviation, 2e-15);
    ASSERT_LT((rigid.pose.linear() - pose.linear()).norm(), 2e-15);
  }
  const RigidPose identity = nearest_rigid(Matrix::Identity());
  EXPECT_EQ(identity.pose.matrix(), Pose::Identity().matrix());
  EXPECT_EQ(identity.deviation, 0);
  Eigen::Matrix<float, 3, 4> moved = Eigen::Matrix<float, 3, 4>::Identity();
  moved.col(3) << 1, 2, 3;
  EXPECT_EQ(nearest_rigid(moved).pose.translation(), Vector(1, 2, 3));
  EXPECT_EQ(nearest_rigid(moved.leftCols<3>()).pose.translation(), Vector::Zero());
}

TEST(RigidPoses, DriftIsMended) {
  Pose pose = Pose::Identity();
  const Matrix step = Eigen::AngleAxisd(0.01, Vector(1, 2, 3).normalized()).toRotationMatrix() * (1 + 1e-11);
  for (int i = 0; i < 2000; ++i) {
    pose.linear() = step * pose.linear();
    pose = nearest_rigid(pose.matrix()).pose;
  }
  EXPECT_LT(departure_from_rigid(pose.linear()), 1e-14);
}

TEST(RigidPoses, NameTheReasonOfARefusal) {
  const auto says = [](const std::string& reason) { return "nearest rigid pose: the matrix " + reason; };
  const auto refused = [](const Matrix& m) { return refusal([&] { nearest_rigid(m); }); };
  const std::string singular = says("is singular, or nearly so: it has no nearest rotation that rounding leaves alone");
  EXPECT_EQ(refused(Matrix::Zero()), says("is zero"));
  EXPECT_EQ(refused(Vector(1, 1, 0).asDiagonal()), singular);
  EXPECT_EQ(refused(Vector(1, 1, 1e-7).asDiagonal()), singular);
  EXPECT_EQ(refused(Vector(1e-300, 1e-300, 1e-309).asDiagonal()), singular);
  EXPECT_EQ(refused(Vector(1, 1, 1e-5).asDiagonal()), "accepted");
  EXPECT_EQ(refused(Vector(1, -1, 1).asDiagonal()),
            says("mirrors: its determinant is negative; bake the mirrored mesh instead"));
  for (const double bad : {no_number, endless}) {
    Matrix m = Matrix::Identity();
    m(2, 0) = bad;
    EXPECT_EQ(refused(m), "nearest rigid pose: an entry of the matrix is not finite");
  }
  Eigen::Matrix4d whole = Eigen::Matrix4d::Identity();
  whole(1, 3) = 1e300;
  EXPECT_EQ(refusal([&] { nearest_rigid(whole); }),
            "nearest rigid pose: coordinate 1 of the translation is 1e+300, not finite or beyond 1e150");
  whole(1, 3) = no_number;
  EXPECT_EQ(refusal([&] { nearest_rigid(whole); }),
            "nearest rigid pose: coordinate 1 of the translation is nan, not finite or beyond 1e150");
  whole.setIdentity();
  whole(3, 0) = 5;
  EXPECT_EQ(refusal([&] { nearest_rigid(whole); }),
            "nearest rigid pose: the last row of the matrix is not 0 0 0 1; is the matrix transposed?");
}

TEST(RigidPoses, QuaternionsInFloatGiveUsablePoses) {
  shapes::Random random(4);
  for (int i = 0; i < 2000; ++i) {
    Eigen::Quaternionf q = random_quaternion(random);
    if (i % 4 == 0) q.coeffs() *= 1 + static_cast<float>(random(-9e-4, 9e-4));
    const RigidPose rigid = pose_from(q, Eigen::Vector3f(1, 2, 0.5F));
    ASSERT_TRUE(is_usable(rigid.pose));
    ASSERT_EQ(rigid.pose.translation(), Vector(1, 2, 0.5));
    ASSERT_LT(rigid.deviation, i % 4 == 0 ? 6e-3 : 1e-6);
    expect_bounded(q.cast<Real>().toRotationMatrix(), rigid, random);
  }
  const auto refused = [](const Eigen::Quaterniond& q) { return refusal([&] { pose_from(q, Vector::Zero()); }); };
  EXPECT_EQ(refused({1, 0, 0, 0}), "accepted");
  EXPECT_EQ(refused({0.5, 0, 0, 0}), "pose: the quaternion's length is 0.5, not 1: normalise it");
  EXPECT_EQ(refused({0, 0, 0, 0}), "pose: the quaternion's length is 0, not 1: normalise it");
  EXPECT_EQ(refused({no_number, 0, 0, 1}), "pose: the quaternion's length is nan, not 1: normalise it");
  EXPECT_EQ(refusal([] { pose_from(Eigen::Quaterniond::Identity(), Vector(0, 0, endless)); }),
            "pose: coordinate 2 of the translation is inf, not finite or beyond 1e150");
}

// A long beam at a pose in float, and a small cube around the exact image of one of its corners: they overlap.
TEST(RigidPoses, CorrectionMarginMissesNothing) {
  shapes::Random random(5);
  const TriangleMesh beam = shapes::box(Vector(-100, -1, -1), Vector(100, 1, 1));
  const ShapePtr beam_shape = make_shape(beam);
  int wrong_without = 0;
  for (int i = 0; i < 1000; ++i) {
    const double half = std::pow(10.0, random(-9, -4)), scale = i % 2 == 0 ? 1 : random(0.1, 3);
    const Matrix matrix = random_quaternion(random).toRotationMatrix().cast<double>();
    const RigidPose rigid = nearest_rigid(matrix);
    const Vector corner = scale * beam.vertex(random.integer(8));
    const ShapePtr cube = make_shape(shapes::cube(half));
    const Motion at = Motion::resting(rigid.pose, scale), there = Motion::resting(shift(0));
    Motion cube_at = there;
    cube_at.start.translation() = cube_at.end.translation() = matrix * corner;
    const double margin = correction_margin(*beam_shape, rigid.deviation, scale);
    ASSERT_FALSE(separated(*beam_shape, at, *cube, cube_at, margin).separated) << half;
    ASSERT_LT(margin, 1e-4 * scale);
    wrong_without += separated(*beam_shape, at, *cube, cube_at).separated ? 1 : 0;
  }
  EXPECT_GT(wrong_without, 100);
  EXPECT_EQ(correction_margin(*beam_shape, 0, 5), 0);
}

TEST(MotionDefects, NameReasonAndRemedy) {
  const Pose rest = Pose::Identity();
  Pose mirrored = rest, drifted = rest, far = shift(1e151), turned = rest;
  mirrored.linear()(1, 1) = -1;
  drifted.linear()(0, 1) = 1e-7;
  turned.linear() = Vector(-1, -1, 1).asDiagonal();
  EXPECT_EQ(motion_defect({rest, rest}), "");
  EXPECT_EQ(motion_defect({mirrored, rest}), "the start pose mirrors the body");
  EXPECT_EQ(motion_defect({rest, far}), "the end pose is farther than 1e150 away");
  EXPECT_EQ(motion_defect({rest, drifted}),
            "the end pose is 1.41e-07 from rigid, farther than 1e-9: correct it by nearest_rigid() or pose_from()");
  EXPECT_EQ(motion_defect({rest, turned}),
            "the rotation within the step reaches 180 degrees: split it, e.g. by split_motion()");
  for (const double scale : {0.0, -1.0, no_number, 1e60}) {
    EXPECT_FALSE(is_usable(Motion::resting(rest, scale)));
    EXPECT_EQ(motion_defect(Motion::resting(rest, scale)).substr(0, 10), "the scale ") << scale;
  }
}

}  // namespace
}  // namespace encage::test
