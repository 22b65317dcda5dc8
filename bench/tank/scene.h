// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/rigid_body.h"

#include <encage/error.h>
#include <encage/shape.h>

#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace encage::tank {

enum class TankScene {
  drop,      ///< bodies enter one by one; no energy is added
  bouncing,  ///< when all are in, their mean kinetic energy is kept above a floor
  resting,   ///< when all are in, their energy is drained until almost none is left
};

const char* name(TankScene scene) noexcept;
/// Throws Error naming the scenes there are.
TankScene scene_named(const std::string& name);

/// A tank with a square base, a floor at z = 0 and no top, and the bodies that fall into it. World units are those of
/// the mesh; gravity counts them as metres.
struct TankOptions {
  TankScene scene = TankScene::drop;
  int bodies = 18;
  double seconds = 16;
  double dt = 1.0 / 960;
  /// Half the inner width of the tank; 1.089 radii of the body if not given.
  std::optional<double> half_width;
  double drop_interval = 0.6;  ///< seconds from one body's entry to the next
  double restitution = 0.99;
  double gravity = 9.81;
  /// bouncing: mean kinetic energy of a body, at least, as the height of a fall in radii.
  double floor_height = 1;
  /// resting: mean kinetic energy in the end. Bodies without any would press on each other everywhere at once; impulses
  /// do not reach through such a pile in a few passes, and much of it has to be held.
  double rest_height = 0.01;
  std::uint64_t seed = 1;  ///< of the initial orientations
  bool collisions = true;  ///< between bodies; without, only the walls stop them
};

/// Throws Error naming the option and the reason; also if the body does not fit into the tank.
void validate(const TankOptions& options, const MassProperties& mass);

/// Of the options, or the default for the body.
double half_width(const TankOptions& options, const MassProperties& mass) noexcept;

/// Floor, then the walls at -x, +x, -y, +y.
std::vector<HalfSpace> tank_walls(double half_width);

/// Where the bodies enter: one generator for all, in the order of the bodies.
class Entries {
 public:
  Entries(const TankOptions& options, const MassProperties& mass);

  /// The next body, at rest with a random orientation: a tenth of a radius above `top`, that of the balls that hold
  /// those that are in, its centre at least three radii above the floor.
  BodyState next(double top);

  std::int64_t entry_step(int body) const;

 private:
  double uniform();

  TankOptions options_;
  const MassProperties& mass_;
  std::mt19937_64 bits_;
};

/// Factor by which all velocities are multiplied before a step. `mean_kinetic` is the energy per body, `seconds` the
/// time since the last body entered.
double velocity_factor(const TankOptions& options, const MassProperties& mass, double mean_kinetic, double seconds);

}  // namespace encage::tank
