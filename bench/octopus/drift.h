// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/poses.h>

#include <cstdint>
#include <vector>

namespace encage::octopus {

/// Poses for bodies of circumradius 1 that drift and tumble on prescribed smooth paths, closely packed in a narrow,
/// tall tank. Nothing is simulated: bodies do not feel each other and may interpenetrate for a while.
struct Drift {
  std::int32_t bodies = 18;
  std::int64_t steps = 480;
  double dt = 1.0 / 480;  ///< seconds between two steps
};

/// The same bits on every machine. Throws Error if a count is below 1 or dt is not positive.
std::vector<PoseStep> drifting_poses(const Drift& drift);

}  // namespace encage::octopus
