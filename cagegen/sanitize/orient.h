// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/sanitize/edge_table.h"

#include <encage/mesh.h>

#include <cstdint>
#include <vector>

namespace encage::io {

/// Triangles connected through edges with exactly two sides.
struct Components {
  std::vector<std::int32_t> label;  ///< per triangle, in order of the smallest triangle; -1 if it repeats a vertex
  std::int32_t count = 0;
};

/// Turns triangles so that neighbours agree, with the first triangle of each component; leaves components that agree
/// already and those that cannot (Moebius strips). Toggles `turned` of every triangle that it turns.
Components make_consistent(Triangles& triangles, const EdgeTable& edges, std::vector<char>& turned);

/// The closed surfaces that the mesh consists of, as lists of triangles; open ones are left out.
std::vector<std::vector<std::int32_t>> closed_parts(const TriangleMesh& mesh, const EdgeTable& edges,
                                                    const Components& components);

/// Turns closed parts so that no point has a negative winding number: a part inside no other one encloses its
/// volume from outside. Parts inside keep their orientation relative to the one around them, so that cavities stay
/// cavities even if the whole input is inside out. Toggles `turned`.
void turn_outward(TriangleMesh& mesh, const std::vector<std::vector<std::int32_t>>& parts, std::vector<char>& turned);

}  // namespace encage::io
