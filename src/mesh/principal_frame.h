// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace encage {

/// A symmetric matrix A = axes * diag(values) * axes^T.
struct PrincipalFrame {
  Eigen::Matrix3d axes;    ///< columns: a right-handed orthonormal frame
  Eigen::Vector3d values;  ///< ascending
};

/// Eigenvalues and -vectors by cyclic Jacobi rotations (Golub and Van Loan, "Matrix computations", section
/// 8.5): additions, multiplications, divisions and square roots only, hence the same bits on every machine.
/// Reads the lower triangle; the entries must be finite.
PrincipalFrame principal_frame(const Eigen::Matrix3d& symmetric) noexcept;

}  // namespace encage
