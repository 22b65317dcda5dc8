// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/shape.h>

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace encage::assets {

struct DriftSceneOptions {
  int bodies = 2000;
  double spacing = 8;   ///< edge of the cube of space that each body has on average; bodies are 1 in radius or less
  double speed = 0.02;  ///< way per step, at most
  double turn = 0.02;   ///< angle per step, at most
};

/// Bodies that drift and turn in a cubic room, each in its own direction, back from the walls and from each other. The
/// same on every machine but for rounding of sines and cosines.
class DriftScene {
 public:
  explicit DriftScene(const DriftSceneOptions& options);
  /// What each body does in the present step.
  const std::vector<Motion>& motions() const { return motions_; }
  /// The next step: pairs that met swap their velocities, if they approach each other.
  void advance(std::span<const std::pair<std::size_t, std::size_t>> met);

 private:
  struct Drifter {
    Eigen::Vector3d velocity;
    Eigen::Matrix3d turn;
  };
  void move(std::size_t body);

  double half_width_;
  std::vector<Drifter> bodies_;
  std::vector<Motion> motions_;
};

}  // namespace encage::assets
