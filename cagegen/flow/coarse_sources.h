// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/flow/flow_level.h"

#include <encage/mesh.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace encage::makers {

/// A way to a coarse mesh.
struct CoarseSource {
  std::string name;                                   ///< "regular", "wrap/20", ...
  std::function<std::optional<TriangleMesh>()> make;  ///< closed, embedded, float32; no value: it cannot be had
  int group = 0;                                      ///< those of a group compete in the flow; groups come in order
  bool last_resort = false;                           ///< loose: only if all before have failed
};

/// What to try for a level, in this order. What is made lives as long as `obstacle`, `request` and `choices`.
std::vector<CoarseSource> coarse_sources(const Obstacle& obstacle, const LevelRequest& request,
                                         const FlowChoices& choices, const std::function<void()>& check);

/// Drops the components of a coarse mesh in which nothing of F lies after the flow: minimising the volume, they would
/// vanish, and turn inside out. Voids stay. `moved` is the coarse mesh as F flowed into it, with the same triangles.
void drop_empty_parts(TriangleMesh& coarse, TriangleMesh& moved, const Obstacle& flowed);

}  // namespace encage::makers
