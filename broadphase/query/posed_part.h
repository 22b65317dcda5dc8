// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/motion/pose.h"
#include "broadphase/shape/compound.h"
#include "src/limits.h"

#include <Eigen/Geometry>

namespace encage {

/// A simple shape at the start of its motion: maps between the world and the local frame of its surfaces.
class PosedPart {
 public:
  /// The pose is usable. Inside the inverse of a nearly orthonormal matrix is off by 33 units of roundoff.
  explicit PosedPart(const MovingPart& part) noexcept
      : shape_(part.shape),
        linear_(part.motion.start.linear()),
        translation_(part.motion.start.translation()),
        scale_(part.motion.scale),
        first_triangle_(part.first_triangle),
        slack_(part.slack) {
    to_local_ = linear_.inverse();
    size_ = translation_.norm() + scale_ * shape_->frame.reach();
    departure_ = departure_from_rigid(linear_);
  }

  const SimpleShape& shape() const { return *shape_; }
  double scale() const { return scale_; }
  std::int32_t first_triangle() const { return first_triangle_; }

  Eigen::Vector3d local(const Eigen::Vector3d& world) const {
    return to_local_ * (world - translation_) / scale_ - shape_->frame.origin;
  }
  Eigen::Vector3d local_direction(const Eigen::Vector3d& world) const { return to_local_ * world / scale_; }
  Eigen::Vector3d world(const Eigen::Vector3d& local) const {
    return linear_ * (scale_ * (shape_->frame.origin + local)) + translation_;
  }
  /// Maps a normal, of any length.
  Eigen::Vector3d world_normal(const Eigen::Vector3d& local) const { return to_local_.transpose() * local; }
  /// Maps a normal of the world to the local frame, but for a factor.
  Eigen::Vector3d local_normal(const Eigen::Vector3d& world) const { return linear_.transpose() * world; }

  /// Returns what a length of the local frame is in the world at least, and what one of the world is there at most.
  double shortest(double local) const { return (1 - departure_ - 8 * eps) * scale_ * local; }
  double farthest_local(double world) const { return (1 + 2 * departure_ + 8 * eps) * world / scale_; }

  /// World units. Bounds the errors of local() and world() for points with norms up to `norm`, of directions over such
  /// a length, and of what a query computes with them (docs/guarantee.md, "Queries of one body").
  double rounding(double norm) const { return 96 * eps * (norm + size_) + slack_; }
  /// World units. Bounds how far the body as it was baked is from the fine mesh, or reaches out of the cages.
  double fine_error() const { return shape_->error_in_world(scale_); }

 private:
  const SimpleShape* shape_;
  Eigen::Matrix3d linear_, to_local_;
  Eigen::Vector3d translation_;
  double scale_;
  std::int32_t first_triangle_;
  double slack_;
  double size_ = 0, departure_ = 0;
};

}  // namespace encage
