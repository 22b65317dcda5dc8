// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/broadphase.h>
#include <encage/error.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "bench/tank/rigid_body.h"

namespace encage::tank {

enum class Scene {
  drop,      ///< bodies enter one by one; no energy is added
  bouncing,  ///< when all are in, their mean kinetic energy is kept above a floor
  resting,   ///< when all are in, their energy is drained
};

const char* name(Scene scene) noexcept;
/// Throws Error naming the scenes there are.
Scene scene_named(const std::string& name);

/// A tank with a square base, a floor at z = 0 and no top, and the bodies that fall into it. World units are
/// those of the mesh; gravity counts them as metres.
struct SceneOptions {
  Scene scene = Scene::drop;
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
  std::uint64_t seed = 1;  ///< of the initial orientations
  bool collisions = true;  ///< between bodies; without, only the walls stop them
};

/// Throws Error naming the option and the reason; also if the body does not fit into the tank.
void validate(const SceneOptions& options, const MassProperties& mass);

double half_width(const SceneOptions& options, const MassProperties& mass) noexcept;

/// Floor, then the walls at -x, +x, -y, +y.
std::array<HalfSpace, 5> tank_walls(double half_width);

}  // namespace encage::tank
