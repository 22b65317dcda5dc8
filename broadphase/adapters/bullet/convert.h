// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
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

}  // namespace encage::bullet
