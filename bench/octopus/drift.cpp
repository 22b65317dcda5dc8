// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/drift.h"

#include "src/mesh/portable_trig.h"

#include <cmath>
#include <string>

namespace encage::octopus {
namespace {

constexpr double ring_radius = 0.62;    // of the places about the tank's axis
constexpr double rise_per_body = 0.75;  // between consecutive places

// Numbers in [0,1) that belong to a body (splitmix64).
class Numbers {
 public:
  explicit Numbers(std::int32_t body) : state_(0x9e3779b97f4a7c15U * (static_cast<std::uint64_t>(body) + 1)) {}

  double next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    z ^= z >> 31;
    return static_cast<double>(z >> 11) / 9007199254740992.0;
  }
  double between(double low, double high) { return low + (high - low) * next(); }
  Eigen::Vector3d direction() {
    const double z = between(-1, 1), r = std::sqrt(1 - z * z);
    const SinCos turn = sincos_turns(next());
    return {r * turn.cos, r * turn.sin, z};
  }

 private:
  std::uint64_t state_;
};

Eigen::Quaterniond rotation(const Eigen::Vector3d& axis, double turns) {
  const SinCos half = sincos_turns(turns / 2);
  return {half.cos, half.sin * axis.x(), half.sin * axis.y(), half.sin * axis.z()};
}

// One body: it sways about a point on a helix and tumbles about two axes.
class Path {
 public:
  explicit Path(std::int32_t body) {
    Numbers numbers(body);
    const SinCos turn = sincos_turns(body * 0.3819660112501051);  // golden angle
    place_ = {ring_radius * turn.cos, ring_radius * turn.sin, 1 + rise_per_body * body};
    for (int axis = 0; axis < 3; ++axis) {
      sway_[axis] = numbers.between(0.10, 0.25);
      sway_rate_[axis] = numbers.between(0.25, 0.6);
      sway_phase_[axis] = numbers.next();
    }
    start_ = rotation(numbers.direction(), numbers.next());
    inner_axis_ = numbers.direction();
    outer_axis_ = numbers.direction();
    inner_rate_ = numbers.between(0.1, 0.3);
    outer_rate_ = numbers.between(-0.3, 0.3);
  }

  Eigen::Isometry3d at(double seconds) const {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const Eigen::Quaterniond q =
        rotation(outer_axis_, outer_rate_ * seconds) * rotation(inner_axis_, inner_rate_ * seconds) * start_;
    pose.linear() = q.normalized().toRotationMatrix();
    for (int axis = 0; axis < 3; ++axis) {
      const SinCos s = sincos_turns(sway_rate_[axis] * seconds + sway_phase_[axis]);
      pose.translation()[axis] = place_[axis] + sway_[axis] * s.sin;
    }
    return pose;
  }

 private:
  Eigen::Vector3d place_, sway_, sway_rate_, sway_phase_, inner_axis_, outer_axis_;  // rates in turns per second
  Eigen::Quaterniond start_;
  double inner_rate_, outer_rate_;
};

}  // namespace

std::vector<PoseStep> drifting_poses(const Drift& drift) {
  if (drift.bodies < 1) throw Error("poses: " + std::to_string(drift.bodies) + " bodies: there must be one at least");
  if (drift.steps < 1) throw Error("poses: " + std::to_string(drift.steps) + " steps: there must be one at least");
  if (!(drift.dt > 0) || !std::isfinite(drift.dt)) throw Error("poses: the time step must be positive");
  std::vector<Path> paths;
  for (std::int32_t body = 0; body < drift.bodies; ++body) paths.emplace_back(body);
  std::vector<PoseStep> steps;
  for (std::int64_t step = 0; step < drift.steps; ++step) {
    PoseStep poses{step, {}};
    for (std::int32_t body = 0; body < drift.bodies; ++body) {
      poses.bodies.push_back({body, paths[body].at(static_cast<double>(step) * drift.dt)});
    }
    steps.push_back(std::move(poses));
  }
  return steps;
}

}  // namespace encage::octopus
