// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/bake/level_maker.h"

#include <encage/bake.h>

#include <cstddef>
#include <string>
#include <vector>

namespace encage {

/// The levels of one chain to make, fine to coarse, and by which method.
struct Recipe {
  std::string name;
  std::vector<LevelTarget> targets;
};

/// The levels that came of a recipe.
struct Chain {
  std::string name;
  std::vector<MadeLevel> levels;
  std::vector<std::string> skipped;  ///< one message for every target that a finer level meets
  /// The sum of the volumes of all targets, a skipped target counting as the finer level that meets it. It orders
  /// chains as the sum of volume ratio - 1 does, and a chain gains nothing by having fewer levels.
  double volume = 0;
  std::string failure;  ///< the level that failed and why; empty if none did
  /// Of the targets that were not met, fine to coarse: one failed, or time was up.
  std::vector<LevelTarget> missing;
  bool complete = false;  ///< no level is missing
};

/// The chains that compete for these levels under the options; never empty. `coarse` holds the user's meshes in the
/// local frame.
std::vector<Recipe> recipes(const BakeOptions& options, const std::vector<std::int64_t>& faces,
                            const std::vector<TriangleMesh>& coarse);

/// The number of a chain among all that are made.
struct ChainRank {
  std::size_t number = 0;
  std::size_t count = 1;
  bool expendable =
      false;  ///< another chain has levels; otherwise the first level of this one is made even if time is up
};

/// Makes the levels until one fails or time is up.
Chain make_chain(LevelMaker& maker, const Recipe& recipe, const ChainRank& rank);

/// The tightest of the complete chains, the first among equals. If there is none: one that only time cut short; then
/// the one with most levels.
Chain best_chain(std::vector<Chain> chains);

}  // namespace encage
