// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/scale/scene.h"

#include "bench/common/clock.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace encage::scale {
namespace {

// Cubic diameters a body has for itself: some three pairs of boxes a body, and some eight.
constexpr double gas_room = 0.75, pile_room = 0.28;

double diameter(const Shape& shape) {
  const Eigen::AlignedBox3d box = world_box(shape, {});
  return box.sizes().norm();
}

}  // namespace

ScaleScene::ScaleScene(const ScaleSceneOptions& options, std::vector<ShapePtr> shapes)
    : options_(options), shapes_(std::move(shapes)) {
  for (const ShapePtr& shape : shapes_) diameter_ += diameter(*shape) / static_cast<double>(shapes_.size());
  const auto count = static_cast<std::size_t>(options_.bodies);
  const bool dense = options_.kind == ScaleSceneKind::pile || options_.kind == ScaleSceneKind::flow;
  half_ = 0.5 * diameter_ * std::cbrt(static_cast<double>(count) * (dense ? pile_room : gas_room));
  motions_.resize(count);
  boxes_.resize(count);
  float_boxes_.resize(count);
  for (std::size_t n = 0; n < count; ++n) {
    if (dense) {
      add_lattice(n);
    } else {
      add_gas(n);
    }
    motions_[n].end.linear() = states_[n].turn.toRotationMatrix();
    motions_[n].end.translation() = states_[n].place;
  }
  advance();
  moved_.resize(count);
  std::iota(moved_.begin(), moved_.end(), 0u);
}

Eigen::Vector3d ScaleScene::random_point() {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const double x = uniform(random_), y = uniform(random_), z = uniform(random_);
  return {x, y, z};
}

Eigen::Quaterniond ScaleScene::random_turn(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, random_point().normalized()));
}

void ScaleScene::add_gas(std::size_t n) {
  State& state = states_.emplace_back();
  state.place = half_ * random_point();
  state.velocity = options_.speed * diameter_ * random_point().normalized();
  state.turn = random_turn(3 * random_point().x());
  state.spin = random_turn(options_.speed);
  state.moving = options_.kind != ScaleSceneKind::tenth || n % 10 == 0;
}

/// Layer by layer, as bodies would be dropped.
void ScaleScene::add_lattice(std::size_t n) {
  const auto edge = static_cast<std::size_t>(std::ceil(std::cbrt(static_cast<double>(options_.bodies)) - 1e-9));
  const double pitch = 2 * half_ / static_cast<double>(edge);
  const Eigen::Vector3d cell(static_cast<double>(n % edge), static_cast<double>(n / edge % edge),
                             static_cast<double>(n / edge / edge));
  State& state = states_.emplace_back();
  state.place = (pitch * (cell.array() + 0.5) - half_).matrix() + 0.3 * pitch * random_point();
  state.velocity = options_.speed * diameter_ * random_point().normalized();
  state.turn = random_turn(3 * random_point().x());
  state.spin = random_turn(options_.speed);
}

void ScaleScene::move_gas(State& state) {
  state.place += state.velocity;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(state.place[k]) > half_ && state.place[k] * state.velocity[k] > 0) state.velocity[k] *= -1;
  }
  state.turn = (state.spin * state.turn).normalized();
}

void ScaleScene::move_flow(State& state, bool& jumped) {
  const double x = state.place.x() / half_;
  state.place.z() -= 2 * options_.speed * diameter_ * (1.1 - x * x);
  state.place.x() += 0.1 * state.velocity.x() * std::cos(0.3 * static_cast<double>(step_));
  jumped = state.place.z() < -half_;
  if (jumped) state.place.z() += 2 * half_;
  state.turn = (state.spin * state.turn).normalized();
}

void ScaleScene::move(std::size_t n) {
  State& state = states_[n];
  Motion& motion = motions_[n];
  bool jumped = false;
  switch (options_.kind) {
    case ScaleSceneKind::pile:
      // To and fro.
      state.place += std::cos(0.4 * static_cast<double>(step_) + static_cast<double>(n)) * state.velocity;
      state.turn = ((step_ / 8 % 2 == 0 ? state.spin : state.spin.conjugate()) * state.turn).normalized();
      break;
    case ScaleSceneKind::flow: move_flow(state, jumped); break;
    default: move_gas(state);
  }
  motion.start = motion.end;
  motion.end.linear() = state.turn.toRotationMatrix();
  motion.end.translation() = state.place;
  if (jumped) motion.start = motion.end;
}

double ScaleScene::advance() {
  ++step_;
  moved_.clear();
  for (std::size_t n = 0; n < states_.size(); ++n) {
    // What does not move comes to rest in the first step.
    if (!states_[n].moving && step_ > 1) continue;
    move(n);
    if (!states_[n].moving) motions_[n] = Motion::resting(motions_[n].end);
    moved_.push_back(static_cast<std::uint32_t>(n));
  }
  double seconds = 0;
  {
    const bench::CpuTimer timer(seconds);
    for (const std::uint32_t n : moved_) boxes_[n] = world_box(*shapes_[shape_of(n)], motions_[n]);
  }
  for (const std::uint32_t n : moved_) float_boxes_[n] = FloatBox::around(boxes_[n]);
  return seconds;
}

}  // namespace encage::scale
