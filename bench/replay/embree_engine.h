// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"

#include <encage/mesh.h>

#include <cstdint>
#include <memory>

namespace encage::replay {

/// How a tree follows its body: its boxes recomputed (`embree_refit`), or built anew by Morton codes, Embree's fastest
/// builder (`embree_rebuild`).
enum class EmbreeUpdate : std::uint8_t { refit, rebuild };

/// Embree's rtcCollide() on user geometry, one primitive a triangle; triangles are then tested by exact predicates, the
/// first hit ending the tests (not the traversal, which Embree cannot stop). As it needs both trees in one space, trees
/// follow their bodies once per step, in the frame of one body of each group of bodies that are connected by pairs:
/// that body's tree, built once with the best quality, is used as it is. Encage's world boxes are the broad phase, then
/// the gate; bodies without pairs cost nothing. One thread. Surfaces only. `mesh` in the body frame, no triangle
/// degenerate.
std::unique_ptr<Engine> make_embree_engine(const TriangleMesh& mesh, ShapePtr shape, EmbreeUpdate update);

}  // namespace encage::replay
