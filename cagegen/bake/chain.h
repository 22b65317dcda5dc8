// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/bake/level_maker.h"

#include <string>
#include <vector>

namespace encage {

/// Levels, fine to coarse, each made around the one before.
struct Chain {
  std::vector<MadeLevel> levels;
  std::vector<std::string> skipped;  ///< one message for every target that a finer level meets
  std::string failure;               ///< the level that failed and why; empty if none did
  std::vector<LevelTarget> missing;  ///< targets that were not met, fine to coarse: one failed, or time was up
};

/// Makes the levels until one fails or time is up.
Chain make_chain(LevelMaker& maker, const std::vector<LevelTarget>& targets);

}  // namespace encage
