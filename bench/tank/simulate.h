// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/poses.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "bench/tank/recording.h"
#include "bench/tank/scene.h"

namespace encage::tank {

class Detector;

/// Of all bodies present, in units of unit density (mass = volume).
struct Energy {
  double kinetic = 0;
  double potential = 0;  ///< above the floor
};

struct CpuSeconds {
  double boxes = 0;  ///< world boxes of the steps' motions, and which of them overlap
  double pairs = 0;  ///< candidates and narrow phase
  double walls = 0;
  double integration = 0;  ///< trial poses and impulses
};

struct Statistics {
  std::int64_t body_steps = 0;
  std::int64_t held_body_steps = 0;  ///< bodies that stayed where they were because no free motion was found
  double mean_passes = 0;            ///< detections of a step
  int most_passes = 0;
  std::int64_t pair_tests = 0;  ///< pairs handed to the narrow phase
  std::int64_t wall_tests = 0;
  std::int64_t contacts = 0;   ///< conflicts that led to impulses
  std::vector<Energy> energy;  ///< at the end of every step
  double energy_entered = 0;   ///< of the bodies as they entered
  double energy_added = 0;     ///< by `bouncing`, and (negative) drained by `resting`
  double energy_lost = 0;      ///< to restitution, summed over the impulses
  double energy_drift = 0;     ///< change of the total energy that nothing of the above explains
  CpuSeconds cpu;
};

struct Simulation {
  /// Per step the start poses and the first trial end poses.
  Recording recording;
  std::vector<PoseStep> poses;  ///< as committed: poses[s] is where recording.steps[s] begins; one more at the end
  Statistics statistics;
  Hash trajectory_hash;  ///< of the committed poses, in order
};

struct Context {
  /// Called a few times a second at least, from the calling thread; fraction in [0,1].
  std::function<void(double fraction)> progress;
  std::atomic<bool>* cancel = nullptr;  ///< may be set from any thread; noticed after the step
};

/// Simulates the scene; one thread, the same bits every time. Bodies never interpenetrate: a step is committed
/// for a body only if its motion is proven free, the true arc included. Throws Error (bad options,
/// a shape without fine mesh) or Cancelled.
Simulation simulate(const ShapePtr& shape, const MassProperties& mass, const SceneOptions& options,
                    const Context& context = {});

/// The same with other means of detection.
Simulation simulate(const Detector& detector, const MassProperties& mass, const SceneOptions& options,
                    const Context& context = {});

}  // namespace encage::tank
