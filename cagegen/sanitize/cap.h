// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/sanitize/edge_table.h"
#include "cagegen/sanitize/orient.h"

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace encage::io {

/// A closed chain of boundary sides. A cap runs against them: from the head of side i to its tail, which is the head of
/// side i + 1.
using Loop = std::vector<Side>;

/// The boundary as loops that pass no vertex twice (cut where the boundary does). At every edge of several sides these
/// must cancel.
std::vector<Loop> boundary_loops(const Triangles& triangles, const EdgeTable& edges, const Components& components);

/// Triangles that span a loop, on its vertices: by minimal dihedral angles, surface included, and area (Liepa 2003, in
/// CGAL); by ears where that fails or the loop is long. The former takes the cube of the loop's length from `work`, and
/// gives way to ears where less is left.
void cap_loop(const TriangleMesh& mesh, const Loop& loop, std::vector<std::array<std::int32_t, 3>>& triangles,
              std::int64_t& work);

}  // namespace encage::io
