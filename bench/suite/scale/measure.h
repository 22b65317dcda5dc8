// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/suite/scale/engine.h"

#include <functional>
#include <string>
#include <vector>

namespace encage::scale {

struct RaceOptions {
  std::vector<std::string> engines;
  int warm_up = 8;                  ///< steps before the timed ones
  int steps = 20;                   ///< timed ones
  int runs = 3;                     ///< each step counts with its median
  std::int64_t brute_force = 3000;  ///< up to so many bodies all pairs of boxes are looked at
};

struct BroadPhaseTimes {
  std::string name;
  double ms = 0;        ///< CPU milliseconds of a step, mean
  double worst_ms = 0;  ///< of the slowest step
  double pairs = 0;     ///< that the engine gave in a step, mean
  int wrong_steps = 0;  ///< in which it did not give the pairs of the first engine
};

struct RaceResult {
  std::int64_t bodies = 0;
  double moved = 0;                      ///< bodies in a step
  double pairs = 0;                      ///< of boxes in a step
  double boxes_ms = 0;                   ///< world_box() of all bodies that move, which only Encage's time contains
  bool brute_force = false;              ///< the pairs of the first engine have been compared with all
  std::vector<BroadPhaseTimes> engines;  ///< those that take so many bodies
};

/// Engines take turns, a run each; every run goes through the same steps. `turn` is called after each.
RaceResult race(const ScaleSceneOptions& scene, const std::vector<ShapePtr>& shapes, const RaceOptions& options,
                const std::function<void()>& turn);

}  // namespace encage::scale
