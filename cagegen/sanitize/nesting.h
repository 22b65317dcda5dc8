// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <vector>

namespace encage::io {

/// For every part (a closed surface: a list of triangles of `mesh`) the parts around it. A part is inside another one
/// if its box is and if samples of its vertices are, by exact ray crossings. Surfaces that intersect each other give an
/// arbitrary answer, the same on every machine.
std::vector<std::vector<std::int32_t>> containers(const TriangleMesh& mesh,
                                                  const std::vector<std::vector<std::int32_t>>& parts);

/// Signed volume of one part, in cubic units.
double part_volume(const TriangleMesh& mesh, const std::vector<std::int32_t>& part);

}  // namespace encage::io
