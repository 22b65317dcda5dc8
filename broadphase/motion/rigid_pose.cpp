// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pose.h"
#include "src/files/number_text.h"
#include "src/limits.h"

#include <encage/error.h>
#include <encage/rigid_pose.h>

#include <cmath>
#include <string>

namespace encage {
namespace {

/// Returns the transposed adjugate; divided by the determinant it is the inverse of the transpose.
Eigen::Matrix3d cofactors(const Eigen::Matrix3d& m) {
  Eigen::Matrix3d c;
  for (int k = 0; k < 3; ++k) c.col(k) = m.col((k + 1) % 3).cross(m.col((k + 2) % 3));
  return c;
}

/// Newton's iteration X <- (g X + X^-T / g) / 2. The factor g, which the norms of X and its inverse give, makes it
/// converge in some ten rounds from the worst matrix that is accepted, and in three from a float rotation.
Eigen::Matrix3d polar_factor(const Eigen::Matrix3d& matrix) {
  constexpr double largest_ratio = 1e6;
  const auto refuse = [](const std::string& reason) { throw Error("nearest rigid pose: the matrix " + reason); };
  const double largest = matrix.cwiseAbs().maxCoeff();
  if (!(largest > 0)) refuse("is zero");
  Eigen::Matrix3d x = matrix / largest;
  for (int round = 0; round < 30; ++round) {
    const Eigen::Matrix3d c = cofactors(x);
    const double determinant = x.col(0).dot(c.col(0));
    if (round == 0) {
      if (!(std::abs(determinant) * largest_ratio > x.norm() * c.norm())) {
        refuse("is singular, or nearly so: it has no nearest rotation that rounding leaves alone");
      }
      if (determinant < 0) refuse("mirrors: its determinant is negative; bake the mirrored mesh instead");
    }
    const Eigen::Matrix3d inverse = c / determinant;
    const double g = std::sqrt(inverse.norm() / x.norm());
    const Eigen::Matrix3d next = 0.5 * (g * x + inverse / g);
    const double change = (next - x).norm();
    x = next;
    if (change <= 4 * eps) break;
  }
  return x;
}

/// Bounds the spectral norm from above, within 15 %: the fourth root of the Frobenius norm of (D^T D)^2. Entries of the
/// difference, of the products and of the norm have some roundings each, relative to the largest ones.
double norm_bound(const Eigen::Matrix3d& difference) {
  const double largest = difference.cwiseAbs().maxCoeff();
  if (largest == 0) return 0;
  const Eigen::Matrix3d d = difference / largest, square = d.transpose() * d;
  return largest * std::sqrt(std::sqrt((square * square).norm())) * (1 + 64 * eps);
}

void check_translation(const Eigen::Vector3d& translation, const char* what) {
  if (translation.allFinite() && translation.cwiseAbs().maxCoeff() <= largest_length) return;
  int axis = 0;
  while (std::abs(translation[axis]) <= largest_length) ++axis;
  throw Error(std::string(what) + ": coordinate " + std::to_string(axis) + " of the translation is " +
              number_text(translation[axis]) + ", not finite or beyond 1e150");
}

}  // namespace

RigidPose nearest_rigid_of(const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
  if (!linear.allFinite()) throw Error("nearest rigid pose: an entry of the matrix is not finite");
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    throw Error("nearest rigid pose: the last row of the matrix is not 0 0 0 1; is the matrix transposed?");
  }
  RigidPose result;
  result.pose.linear() = polar_factor(linear);
  result.pose.translation() = matrix.topRightCorner<3, 1>();
  check_translation(result.pose.translation(), "nearest rigid pose");
  result.deviation = norm_bound(linear - result.pose.linear());
  return result;
}

RigidPose pose_from(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation) {
  const double length = rotation.norm();
  if (!(std::abs(length - 1) <= 1e-3)) {
    throw Error("pose: the quaternion's length is " + number_text(length) + ", not 1: normalise it");
  }
  check_translation(translation, "pose");
  RigidPose result;
  result.pose.linear() = rotation.normalized().toRotationMatrix();
  result.pose.translation() = translation;
  // Entries of either matrix are off by at most 4 eps.
  result.deviation = norm_bound(rotation.toRotationMatrix() - result.pose.linear()) + 32 * eps;
  return result;
}

RigidPose pose_from(const Eigen::Quaternionf& rotation, const Eigen::Vector3f& translation) {
  return pose_from(Eigen::Quaterniond(rotation.cast<double>()), Eigen::Vector3d(translation.cast<double>()));
}

}  // namespace encage
