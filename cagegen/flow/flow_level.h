// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"

#include <encage/decimator.h>
#include <encage/energy.h>

#include <string>

namespace encage::makers {

/// What only the flow is asked for.
struct FlowChoices {
  const TriangleMesh* undeformed = nullptr;  ///< `clean` as its own decimation made it; null: the same
  const TriangleMesh* coarse = nullptr;      ///< a coarse mesh made by the user, instead of a decimation
  Decimator decimator;                       ///< empty: regular and adaptive, whichever works out better
  std::string decimator_name;                ///< for the result's `start`
  EnergyPtr inflate;                         ///< never null
  EnergyPtr final;                           ///< never null
  FlowPath path = FlowPath::straight;
};

/// Makes a level by flow and re-inflation: decimates, lets F flow into the coarse mesh, moves it back while the cage
/// gives way, minimises the final energy, and asks `accept`. The same for any number of threads. Throws Error, which
/// says why the last coarse mesh could not be nested, and Cancelled.
LevelResult flow_level(const Obstacle& obstacle, const LevelRequest& request, const FlowChoices& choices,
                       Control& control, const Accept& accept);

}  // namespace encage::makers
