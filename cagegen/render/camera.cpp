// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/camera.h"

#include "src/mesh/portable_trig.h"

#include <algorithm>
#include <limits>

namespace encage::render {
namespace {

constexpr double half_field = 0.24;  // tangent of half the vertical field of view: a long lens
constexpr double filled = 0.93;      // part of the picture that the fitted points take

// Directions of a camera at azimuth 0: right, towards the eye, up.
Eigen::Matrix3d frame_of(Axis up) {
  Eigen::Matrix3d frame;
  switch (up) {
    case Axis::x: frame << 0, 1, 0, 0, 0, -1, 1, 0, 0; break;
    case Axis::y: frame << 1, 0, 0, 0, 0, 1, 0, 1, 0; break;
    case Axis::z: frame << 1, 0, 0, 0, -1, 0, 0, 0, 1; break;
  }
  return frame;
}

// The best position of the eye along one axis of the picture: |x - position| <= slope * (depth + distance) for all
// points with the smallest distance.
struct Fit {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();

  void add(double x, double depth, double slope) {
    low = std::max(low, x - slope * depth);
    high = std::min(high, x + slope * depth);
  }
  double middle() const { return (low + high) / 2; }
  double distance(double slope) const { return (low - high) / (2 * slope); }
};

}  // namespace

View::View(const Camera& camera, int width, int height, const std::vector<Eigen::Vector3d>& points)
    : middle_(width / 2.0, height / 2.0) {
  const SinCos azimuth = sincos_turns(camera.azimuth / 360);
  const SinCos elevation = sincos_turns(camera.elevation / 360);
  const Eigen::Matrix3d frame = frame_of(camera.up);
  const Eigen::Vector3d side = frame.row(0), front = frame.row(1), top = frame.row(2);
  const Eigen::Vector3d horizontal = azimuth.cos * front + azimuth.sin * side;
  right_ = azimuth.cos * side - azimuth.sin * front;
  forward_ = -(elevation.cos * horizontal + elevation.sin * top);
  up_ = elevation.cos * top - elevation.sin * horizontal;

  const double slope_y = half_field * filled;
  const double slope_x = slope_y * width / height;
  Fit fit_x, fit_y;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) {
    box.extend(p);
    fit_x.add(p.dot(right_), p.dot(forward_), slope_x);
    fit_y.add(p.dot(up_), p.dot(forward_), slope_y);
  }
  // The second term keeps the eye away from a mesh that is a point or a line of sight.
  const double distance =
      std::max(fit_x.distance(slope_x), fit_y.distance(slope_y)) + 1e-3 * box.diagonal().norm() + 1e-30;
  double x = fit_x.middle(), y = fit_y.middle();
  if (camera.focus) {
    x = camera.focus->dot(right_);
    y = camera.focus->dot(up_);
  }
  eye_ = x * right_ + y * up_ - distance * forward_;
  focal_ = height / (2 * half_field) * camera.zoom;
}

Eigen::Vector3d View::ray_direction(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d d = pixel - middle_;
  return (d.x() * right_ - d.y() * up_ + focal_ * forward_).normalized();
}

Eigen::Vector2d View::project(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d d = point - eye_;
  const double scale = focal_ / d.dot(forward_);
  return {middle_.x() + scale * d.dot(right_), middle_.y() - scale * d.dot(up_)};
}

Camera camera_along(Axis axis, Axis up) {
  Camera camera;
  camera.up = up;
  camera.elevation = 0;
  camera.azimuth = 0;
  const Eigen::Matrix3d frame = frame_of(up);
  const int a = static_cast<int>(axis);
  if (frame(2, a) != 0) {
    camera.elevation = 90;
  } else if (frame(0, a) != 0) {
    camera.azimuth = 90;
  }
  return camera;
}

}  // namespace encage::render
