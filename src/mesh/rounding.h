// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/mesh.h>

namespace encage {

/// Returns the nearest point with float32 coordinates, which is what an asset stores.
Eigen::Vector3d round_to_float(const Eigen::Vector3d& p);

/// Rounds all vertices. Returns an upper bound of how far a vertex moves.
double round_vertices(TriangleMesh& mesh);

}  // namespace encage
