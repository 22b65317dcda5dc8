// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"

#include <encage/mesh.h>

#include <memory>

namespace encage::replay {

/// ODE: its OPCODE tree in the body frame, built once; a sweep-and-prune space; dCollide() for one contact that need
/// not be the best. The gate is asked in the space's near callback. OPCODE's tree and transforms are float32 whatever
/// ODE's precision. Surfaces only. `mesh` in the body frame.
std::unique_ptr<Engine> make_ode_engine(const TriangleMesh& mesh);

}  // namespace encage::replay
