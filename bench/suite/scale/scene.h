// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "broadphase/world/body_tree.h"

#include <encage/shape.h>

#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace encage::scale {

enum class ScaleSceneKind {
  gas,    ///< bodies cross a cube in all directions, bounce at its walls and spin
  pile,   ///< a dense lattice in which every body rattles about its position
  flow,   ///< a shaft in which bodies fall, faster in the middle, and start at the top again
  tenth,  ///< gas of which one body in ten moves
};

struct ScaleSceneOptions {
  ScaleSceneKind kind = ScaleSceneKind::gas;
  std::int64_t bodies = 1000;
  double speed = 0.03;  ///< in a step, in diameters of a body
};

/// What all engines are told about one step.
struct ScaleFrame {
  std::span<const Motion> motions;           ///< of all bodies
  std::span<const Eigen::AlignedBox3d> box;  ///< world_box() of these
  std::span<const FloatBox> float_box;       ///< contain these
  std::span<const std::uint32_t> moved;      ///< bodies whose motion is another one than in the step before
};

/// Bodies at constant density, whatever their number. Every object made of the same options and shapes goes through the
/// same steps.
class ScaleScene {
 public:
  ScaleScene(const ScaleSceneOptions& options, std::vector<ShapePtr> shapes);

  const std::vector<ShapePtr>& shapes() const { return shapes_; }
  std::size_t shape_of(std::size_t body) const { return body % shapes_.size(); }
  ScaleFrame frame() const { return {motions_, boxes_, float_boxes_, moved_}; }

  /// Goes on by one step. Returns the CPU seconds that world_box() took.
  double advance();

 private:
  struct State {
    Eigen::Vector3d place, velocity;
    Eigen::Quaterniond turn, spin;
    bool moving = true;
  };

  void add_gas(std::size_t n);
  void add_lattice(std::size_t n);
  void move(std::size_t n);
  void move_gas(State& state);
  void move_flow(State& state, bool& jumped);
  Eigen::Vector3d random_point();  ///< in the cube from -1 to 1
  Eigen::Quaterniond random_turn(double angle);

  ScaleSceneOptions options_;
  std::vector<ShapePtr> shapes_;
  double diameter_ = 0;  ///< of the bodies, mean
  double half_ = 0;      ///< of the cube's edge
  std::int64_t step_ = 0;
  std::minstd_rand random_{1};
  std::vector<State> states_;
  std::vector<Motion> motions_;
  std::vector<Eigen::AlignedBox3d> boxes_;
  std::vector<FloatBox> float_boxes_;
  std::vector<std::uint32_t> moved_;
};

}  // namespace encage::scale
