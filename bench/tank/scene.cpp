// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/scene.h"

#include "src/mesh/portable_trig.h"

#include <algorithm>
#include <cmath>

namespace encage::tank {
namespace {

constexpr double width_in_radii = 1.1 / 1.01;
constexpr double entry_gap = 0.1;       // in radii
constexpr double lowest_entry = 3;      // in radii, of the centre
constexpr double feed_per_second = 8;   // velocities grow by this share at most
constexpr double drain_per_second = 8;  // resting: damping of the velocities in the end
constexpr double seconds_to_full_drain = 2;

[[noreturn]] void refuse(const std::string& option, const std::string& reason) {
  throw Error("simulation: " + option + " " + reason);
}

void require(bool holds, const char* option, double value, const char* reason) {
  if (!holds) refuse(option, std::to_string(value) + ": " + reason);
}

Eigen::Matrix3d matrix(double w, double x, double y, double z) {
  Eigen::Matrix3d r;
  r << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return r;
}

}  // namespace

const char* name(TankScene scene) noexcept {
  switch (scene) {
    case TankScene::drop: return "drop";
    case TankScene::bouncing: return "bouncing";
    case TankScene::resting: return "resting";
  }
  return "?";
}

TankScene scene_named(const std::string& text) {
  for (const TankScene scene : {TankScene::drop, TankScene::bouncing, TankScene::resting}) {
    if (text == name(scene)) return scene;
  }
  throw Error("simulation: scene '" + text + "': there are drop, bouncing and resting");
}

void validate(const TankOptions& o, const MassProperties& mass) {
  if (o.bodies < 1 || o.bodies > 10'000) refuse("bodies", std::to_string(o.bodies) + ": must be 1 to 10000");
  require(o.dt > 0 && o.dt <= 0.1, "dt", o.dt, "must be above 0 and at most 0.1 seconds");
  require(o.seconds >= o.dt && o.seconds <= 1e5, "seconds", o.seconds, "must be from one time step to 1e5");
  require(o.seconds / o.dt <= 1e7, "seconds", o.seconds, "more than 1e7 time steps");
  require(o.drop_interval >= 0 && o.drop_interval <= 1e5, "drop interval", o.drop_interval, "must be 0 to 1e5 seconds");
  require(o.restitution >= 0 && o.restitution <= 1, "restitution", o.restitution, "must be 0 to 1");
  require(o.gravity >= 0 && o.gravity <= 1e6, "gravity", o.gravity, "must be 0 to 1e6");
  require(o.floor_height >= 0 && o.floor_height <= 1e6, "floor height", o.floor_height, "must be 0 to 1e6 radii");
  require(o.rest_height >= 0 && o.rest_height <= 1e6, "rest height", o.rest_height, "must be 0 to 1e6 radii");
  if (!(mass.mass > 0 && mass.radius > 0)) refuse("body", "has no mass");
  const double width = half_width(o, mass);
  require(width > mass.radius && width <= 1e6 * mass.radius, "half width", width,
          "must be above the body's radius, and at most 1e6 of them");
}

double half_width(const TankOptions& options, const MassProperties& mass) noexcept {
  return options.half_width.value_or(width_in_radii * mass.radius);
}

std::vector<HalfSpace> tank_walls(double half_width) {
  std::vector<HalfSpace> walls = {{Eigen::Vector3d::UnitZ(), 0}};
  for (const double side : {1.0, -1.0}) walls.push_back({side * Eigen::Vector3d::UnitX(), -half_width});
  for (const double side : {1.0, -1.0}) walls.push_back({side * Eigen::Vector3d::UnitY(), -half_width});
  return walls;
}

Entries::Entries(const TankOptions& options, const MassProperties& mass)
    : options_(options), mass_(mass), bits_(options.seed) {}

double Entries::uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }

BodyState Entries::next(double top) {
  // Uniform over the rotations: Shoemake, "Uniform random rotations", Graphics Gems III.
  const double share = uniform(), low = std::sqrt(1 - share), high = std::sqrt(share);
  const SinCos first = sincos_turns(uniform()), second = sincos_turns(uniform());
  const Eigen::Matrix3d orientation = matrix(high * second.cos, low * first.sin, low * first.cos, high * second.sin);
  const double room = 0.9 * (half_width(options_, mass_) - mass_.radius);
  Eigen::Vector3d centre;
  centre.x() = room * (2 * uniform() - 1);
  centre.y() = room * (2 * uniform() - 1);
  centre.z() = std::max(top + (1 + entry_gap) * mass_.radius, lowest_entry * mass_.radius);
  return body_at_rest(mass_, orientation, centre);
}

std::int64_t Entries::entry_step(int body) const { return std::llround(body * options_.drop_interval / options_.dt); }

double velocity_factor(const TankOptions& options, const MassProperties& mass, double mean_kinetic, double seconds) {
  if (options.scene == TankScene::drop || !(mean_kinetic > 0)) return 1;
  const double height = options.scene == TankScene::bouncing ? options.floor_height : options.rest_height;
  const double wanted = std::sqrt(mass.mass * options.gravity * height * mass.radius / mean_kinetic);
  const double feed = 1 + feed_per_second * options.dt;
  if (options.scene == TankScene::bouncing) return std::clamp(wanted, 1.0, feed);
  const double share = std::min(seconds / seconds_to_full_drain, 1.0);
  return std::clamp(wanted, std::max(1 - drain_per_second * share * options.dt, 0.0), feed);
}

}  // namespace encage::tank
