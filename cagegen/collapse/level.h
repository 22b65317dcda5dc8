// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/control.h"
#include "cagegen/geometry/obstacle.h"

#include <encage/bake.h>
#include <encage/mesh.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace encage::makers {

struct LevelRequest {
  const TriangleMesh* clean = nullptr;  ///< the finer surface, without degenerate triangles
  bool manifold = false;                ///< `clean` is a closed oriented manifold
  std::int64_t faces = 0;
  double diagonal = 0;   ///< of the source
  double clearance = 0;  ///< length
  Topology topology = Topology::any;
  bool hull_only = false;  ///< the source is too small for a collapse
  int threads = 1;
};

struct Candidate {
  TriangleMesh cage;
  double volume = 0;
  std::string start;  ///< "offset", "decimate/3", "wrap/50", "hull"
};

/// Conservative collapse to one level: cages from several starts, the smallest volume first. Never
/// empty: the hull comes last. The same for any number of threads. `accept` decides (by exact
/// arithmetic) whether a candidate may be returned; the first accepted is finished and returned.
/// Throws Cancelled.
Candidate build_level(const Obstacle& obstacle, const LevelRequest& request, Control& control,
                      const std::function<bool(const Candidate&)>& accept);

}  // namespace encage::makers
