// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"

namespace encage::makers {

/// Moves the vertices of a cage inward, so that cages can be compared.
void settle(const Obstacle& obstacle, const LevelRequest& request, Control& control, Candidate& candidate);

/// Makes a candidate enclose less: its vertices move inward, and its faces to where they serve most. It stays valid,
/// and never has more faces than were asked for.
void finish_by_volume(const Obstacle& obstacle, const LevelRequest& request, Control& control, Candidate& candidate);

}  // namespace encage::makers
