// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"

#include <encage/mesh.h>

#include <cstdint>
#include <memory>

namespace encage::replay {

/// What FCL bounds triangles with: oriented boxes, alone (`fcl_obb`) or with rectangle swept spheres (`fcl`). In
/// double, for which FCL's library is compiled; `fcl_float`: the same as `fcl` in float, compiled here.
enum class FclVolume : std::uint8_t { obbrss, obb, obbrss_float };

/// FCL: its tree in the body frame, built once; its dynamic box tree as broad phase; its collide() for one contact,
/// which ends at the first. The gate is asked in the broad phase's callback. Surfaces only: a body inside another one
/// does not touch it. `mesh` in the body frame.
std::unique_ptr<Engine> make_fcl_engine(const TriangleMesh& mesh, FclVolume volume);

}  // namespace encage::replay
