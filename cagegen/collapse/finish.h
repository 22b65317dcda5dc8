// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"

namespace encage::makers {

/// Moves the vertices of a cage inward, so that cages can be compared.
void settle(const Obstacle& obstacle, const LevelRequest& request, Control& control, Candidate& candidate);

/// Moves the vertices of a candidate inward as far as that goes. It stays valid.
void finish_by_volume(const Obstacle& obstacle, const LevelRequest& request, Control& control, Candidate& candidate);

/// Moves the faces of a finished candidate to where they make it enclose less. It stays valid, and never has more faces
/// than were asked for.
void redistribute_by_volume(const Obstacle& obstacle, const LevelRequest& request, Control& control,
                            Candidate& candidate);

}  // namespace encage::makers
