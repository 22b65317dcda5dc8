// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"

#include <memory>

namespace encage::replay {

/// Encage itself: world boxes, body-frame trees; what it cannot prove apart touches. The cages of a CageGate are asked
/// within the same call as the trees.
std::unique_ptr<Engine> make_encage_engine(ShapePtr shape);

}  // namespace encage::replay
