// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>

#include <Eigen/Core>

namespace ENCAGE_EXPORT encage {

/// x -> linear x + offset.
struct AffineMap {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator()(const Eigen::Vector3d& x) const { return linear * x + offset; }
};

}  // namespace encage
