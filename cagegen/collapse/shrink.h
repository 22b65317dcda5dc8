// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <functional>

#include "cagegen/geometry/obstacle.h"

namespace encage::makers {

/// Moves all vertices at once to where the cage encloses least: gradient steps of the volume, projected
/// onto linearised contacts with the obstacle and the cage itself. The result encloses no more than
/// `cage`, keeps `clearance` to the obstacle and comes nowhere closer to itself than `self_clearance` or
/// `cage` did. `check` is called often and may throw to cancel.
TriangleMesh shrink(const Obstacle& obstacle, const TriangleMesh& cage, double clearance, double self_clearance,
                    int threads, const std::function<void()>& check);

}  // namespace encage::makers
