// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/octopus/implicit.h"

#include <encage/mesh.h>

#include <cstdint>

namespace encage::octopus {

/// The lattice to polygonize on.
struct Grid {
  double half_width = 0;  ///< the surface lies inside the cube [-half_width, half_width]^3
  double first_cell = 0;  ///< cell size to try first
  /// Rounds that move each vertex towards its neighbours and back onto the surface. They make triangles well shaped;
  /// the mesh stays embedded as long as cells are smaller than the surface's features.
  int relaxations = 4;
};

/// Marching tetrahedra on a body-centred cubic lattice, visited near the surface only: a closed 2-manifold by
/// construction, oriented outward, free of self-intersection before relaxation. The cell size is searched until the
/// mesh has `faces` triangles within `tolerance` (relative); where a coarse lattice cannot give that, the last attempt
/// is returned.
TriangleMesh polygonize(const ImplicitSurface& surface, const Grid& grid, std::int64_t faces, double tolerance);

}  // namespace encage::octopus
