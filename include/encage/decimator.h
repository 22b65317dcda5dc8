// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Coarse meshes for the flow: Dec of Nested Cages, algorithm 1. Offline side.

#include <encage/export.h>
#include <encage/mesh.h>

#include <cstdint>
#include <functional>

namespace ENCAGE_EXPORT encage {

/// Makes a mesh of at most `faces` triangles that resembles `finer`, the level before as it became, M(i-1), or
/// `undeformed`, the same level as its own decimation made it, M^(i-1); the source is both for the first level. Both
/// are closed and manifold (an alpha wrap stands in for sources that are not). The result must be closed, oriented,
/// manifold and free of self-intersection; it may cut through `finer`. Called from one thread at a time.
using Decimator =
    std::function<TriangleMesh(const TriangleMesh& finer, const TriangleMesh& undeformed, std::int64_t faces)>;

/// CGAL's edge collapse with the cost and placement of Lindstrom and Turk: triangles of even size.
Decimator regular_decimator();
/// CGAL's edge collapse with the quadrics of Garland and Heckbert: small triangles where the surface bends.
Decimator adaptive_decimator();

}  // namespace encage
