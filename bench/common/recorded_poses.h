// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/common/recording.h"

#include <encage/cage.h>
#include <encage/poses.h>

#include <cstdint>
#include <string>
#include <vector>

namespace encage::bench {

/// Where a body is in a step; null if it is not there.
const BodyPose* find_body(const PoseStep& step, std::int32_t body);

/// Steps to measure on from poses that were recorded: in each of them, a body moves from its pose in that step to its
/// pose in the next one; every `every`-th step is taken. Bodies that the next step lacks are left out. Throws Error,
/// naming `file`, step and body, if a body turns by 180 degrees or more in a step, and if there are fewer than two
/// steps.
Recording recording_of(const std::vector<PoseStep>& poses, double dt, std::int64_t every, const std::string& file);

/// Of the poses in order, hence equal to Simulation::trajectory_hash for the same poses.
Hash trajectory_hash(const std::vector<PoseStep>& poses);

}  // namespace encage::bench
