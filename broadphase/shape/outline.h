// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace encage {

/// A few points whose convex hull contains a body, for its world boxes.
class Outline {
 public:
  Outline() = default;
  explicit Outline(std::span<const std::array<float, 3>> points);

  bool empty() const { return x_.empty(); }
  std::int64_t bytes() const noexcept { return static_cast<std::int64_t>(3 * sizeof(float) * x_.size()); }
  /// Least and largest coordinates of `rotation` times the points, off by at most 2^-20 of the largest norm of a point.
  void extents(const Eigen::Matrix3d& rotation, Eigen::Vector3d& low, Eigen::Vector3d& high) const noexcept;

 private:
  std::vector<float> x_, y_, z_;  ///< padded by the first point
};

}  // namespace encage
