// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"

#include <memory>

namespace encage::makers {

/// Makes cages by conservative collapse from several starts. Refers to its arguments.
std::unique_ptr<CandidateMaker> collapse_maker(const Obstacle& obstacle, const LevelRequest& request, Control& control);

/// Makes convex cages, which always come through: no cage need enclose more than the tightest of them. Refers to its
/// arguments.
std::unique_ptr<CandidateMaker> convex_maker(const Obstacle& obstacle, const LevelRequest& request, Control& control);

}  // namespace encage::makers
