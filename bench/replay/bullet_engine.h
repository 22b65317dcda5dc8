// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"

#include <encage/mesh.h>

#include <memory>

namespace encage::replay {

/// Bullet: a GImpact mesh, its tree built once and shared by all bodies, in a collision world with the dynamic box tree
/// as broad phase. The gate is asked in the dispatcher's near callback. Margins are 0; a pair touches if its manifold
/// holds a contact at a distance <= 0. All in float32, as Bullet is built by default; GImpact always finds every pair
/// of triangles. Surfaces only. `mesh` in the body frame.
std::unique_ptr<Engine> make_bullet_engine(const TriangleMesh& mesh);

}  // namespace encage::replay
