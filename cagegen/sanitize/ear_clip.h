// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace encage::io {

/// Cuts a closed chain of n >= 3 vertices into n - 2 triangles with its orientation, which use the chain's edges and
/// chords only. A convex polygon becomes the fan of its first vertex; a simple planar polygon is cut by its ears
/// (Meisters 1975), with exact predicates in the coordinate plane that it faces most. Any other chain still gets n - 2
/// triangles that it bounds.
void clip_ears(const Vertices& vertices, std::span<const std::int32_t> chain,
               std::vector<std::array<std::int32_t, 3>>& triangles);

}  // namespace encage::io
