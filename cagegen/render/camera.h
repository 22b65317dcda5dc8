// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/render/render.h"

#include <vector>

namespace encage::render {

/// A pinhole camera. Pixel coordinates: origin in the upper left corner, y down, centre of the first pixel at (0.5,
/// 0.5).
class View {
 public:
  /// Fits `points` into a picture of this size.
  View(const Camera& camera, int width, int height, const std::vector<Eigen::Vector3d>& points);

  const Eigen::Vector3d& eye() const { return eye_; }
  const Eigen::Vector3d& right() const { return right_; }
  const Eigen::Vector3d& up() const { return up_; }
  const Eigen::Vector3d& forward() const { return forward_; }

  /// Of unit length.
  Eigen::Vector3d ray_direction(const Eigen::Vector2d& pixel) const;
  /// The point must lie in front of the eye.
  Eigen::Vector2d project(const Eigen::Vector3d& point) const;

 private:
  Eigen::Vector3d eye_, right_, up_, forward_;
  double focal_ = 1;  // pixels
  Eigen::Vector2d middle_;
};

/// The camera that looks along the axis of a cut, on the plane's positive side (its negative side for y, when that is
/// the front).
Camera camera_along(Axis axis, Axis up);

}  // namespace encage::render
