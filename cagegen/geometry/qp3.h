// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <optional>
#include <span>

namespace encage::makers {

/// normal . p >= offset
struct LinearConstraint {
  Eigen::Vector3d normal;
  double offset;
};

/// Minimises 1/2 p'Ap - b'p (A symmetric positive definite) under the constraints; no value if they exclude each other.
/// Exact up to rounding: incremental, like Seidel's linear programming, in order of the constraints.
std::optional<Eigen::Vector3d> solve_qp(const Eigen::Matrix3d& a, const Eigen::Vector3d& b,
                                        std::span<const LinearConstraint> constraints);

}  // namespace encage::makers
