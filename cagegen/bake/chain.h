// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/bake/level_maker.h"

#include <encage/bake.h>

#include <cstddef>
#include <string>
#include <vector>

namespace encage {

/// How to make a whole chain of levels, fine to coarse.
struct Recipe {
  std::string name;
  std::vector<LevelTarget> targets;
};

/// What became of a recipe.
struct Chain {
  std::string name;
  std::vector<MadeLevel> levels;
  std::vector<std::string> skipped;  ///< one message for every target that a finer level meets
  /// Over all targets, the volume of the level that stands for it; so chains with fewer levels gain nothing. It orders
  /// chains as the sum of volume ratio - 1 does.
  double volume = 0;
  std::string failure;    ///< the level that failed and why; empty if none did
  bool complete = false;  ///< no level is missing
};

/// What competes for these levels under the options; never empty. `coarse` holds the user's meshes, local frame.
std::vector<Recipe> recipes(const BakeOptions& options, const std::vector<std::int64_t>& faces,
                            const std::vector<TriangleMesh>& coarse, std::int64_t source_faces);

/// Where a chain stands among all.
struct ChainPlace {
  std::size_t number = 0;
  std::size_t count = 1;
  bool expendable = false;  ///< another one has made levels; else this one's first is made even if time is up
};

/// Makes the levels until one fails or time is up.
Chain make_chain(LevelMaker& maker, const Recipe& recipe, const ChainPlace& place);

/// The tightest of the complete chains, the first among equals. If there is none: one that only time cut short; then
/// the one with most levels.
Chain best_chain(std::vector<Chain> chains);

}  // namespace encage
