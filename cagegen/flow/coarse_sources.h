// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/flow/flow_maker.h"

#include <encage/mesh.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace encage::makers {

/// Up to so many faces all coarse meshes are nested, and the tightest is kept.
constexpr std::int64_t compete_faces = 300;

/// One way to make a coarse mesh.
struct CoarseSource {
  std::string name;                                   ///< "regular", "wrap/20", ...
  std::function<std::optional<TriangleMesh>()> make;  ///< closed, embedded, float32; no value if it fails
  int group = 0;             ///< sources of a group compete in the flow; groups follow each other
  bool last_resort = false;  ///< makes loose cages: used only if all before have failed
};

/// The sources to try for a level, in this order. They refer to the arguments.
std::vector<CoarseSource> coarse_sources(const LevelRequest& request, const FlowChoices& choices,
                                         const std::function<void()>& check);

/// Drops the components of a coarse mesh that hold no part of F after the flow: minimising the volume would shrink them
/// to nothing and turn them inside out. Voids stay. `moved` is the coarse mesh as F flowed into it, with the same
/// triangles.
void drop_empty_parts(TriangleMesh& coarse, TriangleMesh& moved, const Obstacle& flowed);

}  // namespace encage::makers
