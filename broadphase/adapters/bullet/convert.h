// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <LinearMath/btTransform.h>

#include <limits>

namespace encage::bullet {

constexpr double unit_roundoff = std::numeric_limits<btScalar>::epsilon() / 2;

inline Eigen::Vector3d to_eigen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

inline Eigen::Matrix3d to_eigen(const btMatrix3x3& m) {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) result.row(i) = to_eigen(m[i]).transpose();
  return result;
}

inline btVector3 to_bullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

/// One step of Newton's iteration for the polar factor: a departure of d from a rotation becomes d^2, 1e-14 for float.
inline Eigen::Matrix3d nearer_to_rotation(const Eigen::Matrix3d& r) {
  return r * (1.5 * Eigen::Matrix3d::Identity() - 0.5 * r.transpose() * r);
}

/// The rigid motion nearest to a transform whose basis is a rotation to some 1e-4.
inline Eigen::Isometry3d to_isometry(const btTransform& transform) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = nearer_to_rotation(nearer_to_rotation(to_eigen(transform.getBasis())));
  pose.translation() = to_eigen(transform.getOrigin());
  return pose;
}

}  // namespace encage::bullet
