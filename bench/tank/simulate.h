// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/recording.h"
#include "bench/tank/scene.h"
#include "bench/tank/velocity_filter.h"

#include <encage/poses.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

namespace encage::tank {

/// Of all bodies present, in units of unit density (mass = volume).
struct Energy {
  double kinetic = 0;
  double potential = 0;  ///< above the floor
};

struct Statistics {
  std::int64_t body_steps = 0;
  /// Sums over the steps; held: body-steps for which no free motion was found.
  FilterReport filter;
  std::int64_t most_passes = 0;  ///< detections of a step
  std::int64_t most_held = 0;    ///< bodies of a step
  std::vector<Energy> energy;    ///< at the end of every step
  double energy_entered = 0;     ///< of the bodies as they entered
  double energy_added = 0;       ///< by `bouncing`; negative: drained by `resting`
  double energy_lost = 0;        ///< to restitution, summed over the impulses
  double energy_drift = 0;       ///< change of the total energy that nothing of the above explains
};

struct Simulation {
  /// Per step the start poses and the first trial end poses.
  bench::Recording recording;
  std::vector<PoseStep> poses;  ///< as committed: poses[s] is where recording.steps[s] begins; one more at the end
  Statistics statistics;
  Hash trajectory_hash;  ///< of the committed poses, in order
};

struct SimulationContext {
  /// Called after every step, from the calling thread; fraction in (0,1].
  std::function<void(double fraction)> progress;
  std::atomic<bool>* cancel = nullptr;  ///< may be set from any thread; noticed after the step
};

/// Simulates the scene; one thread, the same bits every time, on every machine, with the same compiler flags. Bodies
/// never interpenetrate: a step is committed for a body only if its motion is proven free, the true arc included.
/// Throws Error (bad options, a shape without fine mesh) or Cancelled.
Simulation simulate(const ShapePtr& shape, const MassProperties& mass, const TankOptions& options,
                    const SimulationContext& context = {});

/// The same with other means of detection.
Simulation simulate(const Detector& detector, const MassProperties& mass, const TankOptions& options,
                    const SimulationContext& context = {});

}  // namespace encage::tank
