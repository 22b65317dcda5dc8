// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/camera.h"

#include "src/mesh/portable_trig.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace encage::render {
namespace {

std::vector<Eigen::Vector3d> some_points() {
  return {{1, 2, 3}, {-1, 0.5, 2}, {0.3, -4, 1}, {2, 2, -1}, {0, 0, 0}, {1.5, -1, 2.5}};
}

TEST(PortableTrig, AgreesWithLibm) {
  for (double turns = -3; turns <= 3; turns += 0.00137) {
    const SinCos s = sincos_turns(turns);
    EXPECT_NEAR(s.sin, std::sin(turns * 6.283185307179586), 1e-12);
    EXPECT_NEAR(s.cos, std::cos(turns * 6.283185307179586), 1e-12);
  }
  EXPECT_EQ(sincos_turns(0.25).sin, 1);
  EXPECT_EQ(sincos_turns(0.25).cos, 0);
  EXPECT_EQ(sincos_turns(-0.5).cos, -1);
}

TEST(View, FitsEveryPointTightly) {
  for (const Axis up : {Axis::x, Axis::y, Axis::z}) {
    for (const double azimuth : {0.0, 35.0, 140.0, -95.0}) {
      for (const double elevation : {-90.0, -30.0, 0.0, 55.0, 90.0}) {
        Camera camera;
        camera.azimuth = azimuth;
        camera.elevation = elevation;
        camera.up = up;
        const View view(camera, 400, 300, some_points());
        double fill_x = 0, fill_y = 0;
        for (const Eigen::Vector3d& p : some_points()) {
          const Eigen::Vector2d q = view.project(p);
          fill_x = std::max(fill_x, std::abs(q.x() - 200) / 200);
          fill_y = std::max(fill_y, std::abs(q.y() - 150) / 150);
        }
        EXPECT_LE(std::max(fill_x, fill_y), 0.95);
        EXPECT_GE(std::max(fill_x, fill_y), 0.9);
      }
    }
  }
}

TEST(View, IsARightHandedFrame) {
  for (const Axis up : {Axis::x, Axis::y, Axis::z}) {
    Camera camera;
    camera.up = up;
    const View view(camera, 400, 300, some_points());
    EXPECT_LT((view.right().cross(view.up()) + view.forward()).norm(), 1e-12);
    EXPECT_GT(view.up()[static_cast<int>(up)], 0.8);
  }
}

TEST(View, RaysUndoProjection) {
  const View view(Camera(), 400, 300, some_points());
  for (const Eigen::Vector3d& p : some_points()) {
    const Eigen::Vector3d direction = view.ray_direction(view.project(p));
    EXPECT_LT((p - view.eye()).normalized().cross(direction).norm(), 1e-12);
  }
}

TEST(View, ZoomAndFocus) {
  Camera camera;
  const View plain(camera, 400, 300, some_points());
  camera.zoom = 2;
  const View zoomed(camera, 400, 300, some_points());
  const Eigen::Vector2d middle(200, 150);
  for (const Eigen::Vector3d& p : some_points()) {
    EXPECT_LT((zoomed.project(p) - middle - 2 * (plain.project(p) - middle)).norm(), 1e-9);
  }
  camera.focus = Eigen::Vector3d(2, 2, -1);
  EXPECT_LT((View(camera, 400, 300, some_points()).project(*camera.focus) - middle).norm(), 1e-9);
}

TEST(CameraAlong, LooksAlongTheAxis) {
  for (const Axis up : {Axis::x, Axis::y, Axis::z}) {
    for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
      const View view(camera_along(axis, up), 400, 300, some_points());
      EXPECT_EQ(std::abs(view.forward()[static_cast<int>(axis)]), 1);
    }
  }
}

}  // namespace
}  // namespace encage::render
