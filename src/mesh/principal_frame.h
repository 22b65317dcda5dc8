// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace encage {

/// A symmetric matrix A = axes * diag(values) * axes^T.
struct PrincipalFrame {
  Eigen::Matrix3d axes;    ///< columns: a right-handed orthonormal frame
  Eigen::Vector3d values;  ///< ascending
};

/// Computes eigenvalues and eigenvectors by cyclic Jacobi rotations (Golub and Van Loan, "Matrix computations", section
/// 8.5). It uses additions, multiplications, divisions and square roots only, so every machine computes the same bits.
/// It reads the lower triangle; the entries must be finite.
PrincipalFrame principal_frame(const Eigen::Matrix3d& symmetric) noexcept;

}  // namespace encage
