// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/level.h"

#include <encage/decimator.h>
#include <encage/energy.h>

#include <memory>
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
  /// Other cages compete: what they do better is left to them (alpha wraps, but for small cages), and a flow that
  /// stalls is given up soon.
  bool competes = false;
};

/// Makes cages by flow and re-inflation: decimates, lets F flow into the coarse mesh, moves it back while the cage
/// gives way, and minimises the final energy. Refers to its arguments.
std::unique_ptr<CandidateMaker> flow_maker(const Obstacle& obstacle, const LevelRequest& request,
                                           const FlowChoices& choices, Control& control);

}  // namespace encage::makers
