// SPDX-License-Identifier: Apache-2.0
#pragma once

// Poses as engines have them: in float, drifted, nearly rigid.

#include <encage/export.h>

#include <Eigen/Geometry>

namespace ENCAGE_EXPORT encage {

/// A rigid pose in place of a matrix that is only nearly rigid.
struct RigidPose {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  /// Without unit, rounded up: the matrix takes no point x farther than deviation * |x| from where the pose takes it
  /// (the spectral norm of the difference, within 15 %). x is in the body frame, at the size that the body has in the
  /// world. Between two corrected poses, vertices are off by no more than the larger deviation says.
  /// correction_margin() makes a margin of it.
  double deviation = 0;
};

/// Returns the pose whose rotation is nearest to the linear part of `matrix`: its orthogonal polar factor, by Newton's
/// iteration (Higham 1986, "Computing the polar decomposition - with applications"). The translation stays. Throws
/// Error, which names the reason, if a number is not finite, the last row is not 0 0 0 1, the translation is beyond
/// 1e150, or the linear part mirrors or is singular (its singular values differ by a factor of more than some 1e6).
/// Re-entrant; allocates nothing.
RigidPose nearest_rigid_of(const Eigen::Matrix4d& matrix);

/// The same for a 3 x 3, 3 x 4 or 4 x 4 matrix of float or double. Without a last column the translation is zero.
template <class Derived>
RigidPose nearest_rigid(const Eigen::MatrixBase<Derived>& matrix) {
  constexpr int rows = Derived::RowsAtCompileTime, columns = Derived::ColsAtCompileTime;
  static_assert((rows == 3 || rows == 4) && (columns == 3 || columns == 4) && rows <= columns,
                "nearest_rigid takes a 3 x 3, 3 x 4 or 4 x 4 matrix");
  Eigen::Matrix4d whole = Eigen::Matrix4d::Identity();
  whole.template topLeftCorner<rows, columns>() = matrix.template cast<double>();
  return nearest_rigid_of(whole);
}

/// Returns the pose of a quaternion, which is normalised in double, and a translation. The deviation compares it with
/// the matrix of the quaternion as it is (1 - 2 (y^2 + z^2), …), in exact arithmetic; an engine that computes that
/// matrix in float rounds it by some 1e-6 more, so pass that matrix to nearest_rigid() where it is at hand. Throws
/// Error if a number is not finite, the quaternion's length is farther than 1e-3 from 1, or the translation is beyond
/// 1e150. Re-entrant; allocates nothing.
RigidPose pose_from(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation);
RigidPose pose_from(const Eigen::Quaternionf& rotation, const Eigen::Vector3f& translation);

}  // namespace encage
