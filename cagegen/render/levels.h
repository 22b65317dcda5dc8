// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/render/render.h"

#include <span>
#include <vector>

namespace encage::render {

/// Level 0 is yellow; cages have colours that stay apart for colour-blind eyes and repeat after six.
Color level_color(int level);

/// The usual picture of nested levels, fine to coarse: the first solid, the last translucent over it with its edges,
/// those between in sections only. `levels[0]` is the source; an empty mesh there is skipped. The meshes must outlive
/// the result.
std::vector<Item> nested_items(std::span<const TriangleMesh> levels);

/// One level alone: the source smooth, a cage with flat, outlined triangles.
Item level_item(const TriangleMesh& mesh, int level);

}  // namespace encage::render
