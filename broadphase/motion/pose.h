// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/motion.h>

#include <string>

namespace encage {

/// True if queries may use the pose: it is finite, it does not mirror, and its linear part is within rigid_tolerance of
/// orthonormal.
bool is_usable(const Eigen::Isometry3d& pose) noexcept;

/// Explains why a pose is not usable, e.g. "is not finite"; empty if it is.
std::string pose_defect(const Eigen::Isometry3d& pose);

/// True if the pose mirrors, e.g. has a negative scale along one axis.
bool is_mirrored(const Eigen::Isometry3d& pose) noexcept;

/// Upper bound of the spectral norm of R^T R - I, rounding included.
double departure_from_rigid(const Eigen::Matrix3d& linear) noexcept;

}  // namespace encage
