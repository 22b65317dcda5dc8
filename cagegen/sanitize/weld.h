// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <span>
#include <vector>

namespace encage::io {

/// For every vertex the first one with exactly equal coordinates (0 equals -0). `coordinates` holds x, y, z of all
/// vertices, finite.
std::vector<std::int32_t> weld(std::span<const double> coordinates);

/// Drops the vertices that no triangle uses; the others keep their order. Returns how many.
Eigen::Index drop_unused_vertices(TriangleMesh& mesh);

}  // namespace encage::io
