// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/assets/scene.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <random>

namespace encage::assets {
namespace {

Eigen::Vector3d random_point(std::mt19937& random, double half) {
  Eigen::Vector3d p;
  for (int k = 0; k < 3; ++k) p[k] = half * (static_cast<double>(random()) / 2147483648.0 - 1);
  return p;
}

Eigen::Matrix3d random_rotation(std::mt19937& random, double angle) {
  Eigen::Vector3d axis;
  do {
    axis = random_point(random, 1);
  } while (axis.norm() > 1 || axis.norm() < 0.1);
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

}  // namespace

DriftScene::DriftScene(const DriftSceneOptions& options) {
  // In the cells of a lattice, apart from each other.
  const int cells = static_cast<int>(std::ceil(std::cbrt(options.bodies) - 1e-9));
  half_width_ = 0.5 * options.spacing * cells;
  std::mt19937 random(1);
  for (int i = 0; i < options.bodies; ++i) {
    const Eigen::Vector3d cell(i % cells, i / cells % cells, i / cells / cells);
    const Eigen::Vector3d middle = options.spacing * (cell.array() + 0.5) - half_width_;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = middle + random_point(random, std::max(0.0, 0.5 * options.spacing - 1));
    pose.linear() = random_rotation(random, static_cast<double>(random()) / 1e9);
    motions_.push_back(Motion::resting(pose));
    bodies_.push_back({random_point(random, options.speed / std::sqrt(3)), random_rotation(random, options.turn)});
    move(motions_.size() - 1);
  }
}

void DriftScene::advance(std::span<const std::pair<std::size_t, std::size_t>> met) {
  for (const auto& [a, b] : met) {
    const Eigen::Vector3d apart = motions_[b].end.translation() - motions_[a].end.translation();
    if ((bodies_[b].velocity - bodies_[a].velocity).dot(apart) < 0) std::swap(bodies_[a].velocity, bodies_[b].velocity);
  }
  for (std::size_t i = 0; i < bodies_.size(); ++i) move(i);
}

void DriftScene::move(std::size_t i) {
  Motion& motion = motions_[i];
  Drifter& body = bodies_[i];
  motion.start = motion.end;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(motion.start.translation()[k]) > half_width_) {
      body.velocity[k] = std::copysign(body.velocity[k], -motion.start.translation()[k]);
    }
  }
  motion.end.translation() += body.velocity;
  motion.end.linear() = Eigen::Quaterniond(body.turn * motion.start.linear()).normalized().toRotationMatrix();
}

}  // namespace encage::assets
