// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/collapse/level.h"
#include "cagegen/control.h"
#include "cagegen/geometry/obstacle.h"

#include <encage/bake.h>
#include <encage/decimator.h>
#include <encage/energy.h>
#include <encage/mesh.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace encage::makers {

struct NestedRequest {
  const TriangleMesh* inner = nullptr;               ///< F, what must be enclosed; as given to the obstacle
  const TriangleMesh* clean = nullptr;               ///< the same surface without degenerate triangles
  bool manifold = false;                             ///< `clean` is a closed oriented manifold
  const TriangleMesh* undeformed = nullptr;          ///< `clean` as its own decimation made it; null: the same
  const TriangleMesh* coarse = nullptr;              ///< a coarse mesh made by the user, instead of a decimation
  Decimator decimator;                               ///< empty: regular and adaptive, whichever works out better
  std::string decimator_name;                        ///< for the result's `start`
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the local frame, for messages
  std::int64_t faces = 0;
  double diagonal = 0;   ///< of the source
  double clearance = 0;  ///< length
  Topology topology = Topology::any;
  EnergyPtr inflate;  ///< never null
  EnergyPtr final;    ///< never null
  FlowPath path = FlowPath::straight;
  int threads = 1;
  std::function<void(std::string_view)> log;  ///< what failed and what was tried instead; may be empty
};

struct NestedResult {
  Candidate candidate;      ///< start: "regular", "adaptive", "user", "wrap/20", ...
  TriangleMesh undeformed;  ///< the coarse mesh before it was moved
  double flow_seconds = 0;
  double reinflate_seconds = 0;
};

/// Flow and re-inflation of one level: decimate, flow, re-inflate, minimise the final energy, and ask `accept`
/// (by exact arithmetic). No value if no coarse mesh could be nested: `failure` says why. Throws Cancelled.
std::optional<NestedResult> build_nested_level(const Obstacle& obstacle, const NestedRequest& request, Control& control,
                                               const std::function<bool(const Candidate&)>& accept,
                                               std::string& failure);

}  // namespace encage::makers
