// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "broadphase/motion/pair_motion.h"

#include <encage/poses.h>

#include <vector>

namespace encage::covers {

/// Two bodies whose world boxes overlap, and what all contestants need of them.
struct PairCase {
  PairMotion motion;
  double distance = 0;  ///< required_distance()
};

/// Step by step.
using PairLists = std::vector<std::vector<PairCase>>;

/// Of every `every`-th step; `moving`: on the way to the next recorded step, else at rest. Bodies that the next
/// step lacks, or that turn too far, are left out. Throws Error if no steps are left.
PairLists make_pairs(const Shape& shape, const std::vector<PoseStep>& poses, std::int64_t every, bool moving);

}  // namespace encage::covers
