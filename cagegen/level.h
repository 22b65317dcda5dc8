// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What both makers of a level are asked for and give: collapse_level() and flow_level().

#include "cagegen/geometry/obstacle.h"
#include "cagegen/threads/control.h"

#include <encage/bake.h>
#include <encage/mesh.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace encage::makers {

/// Distance that a level keeps to itself, in clearances: the next level must fit between two of its strands.
constexpr double self_clearances = 6;

struct LevelRequest {
  const TriangleMesh* inner = nullptr;               ///< what must be enclosed; the obstacle is made of it
  const TriangleMesh* clean = nullptr;               ///< the same surface without degenerate triangles
  bool manifold = false;                             ///< `clean` is a closed oriented manifold
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the local frame, for messages
  std::int64_t faces = 0;                            ///< at most
  double diagonal = 0;                               ///< of the source
  double clearance = 0;                              ///< least distance to the obstacle, a length
  Topology topology = Topology::any;
  int threads = 1;                            ///< never changes the result
  std::function<void(std::string_view)> log;  ///< what failed and what was tried instead; may be empty
};

/// A cage that may become the level.
struct Candidate {
  TriangleMesh cage;
  double volume = 0;
  std::string start;    ///< "decimate", "wrap/50", "hull", "box", "tetrahedron", "regular", "adaptive", "user"
  bool convex = false;  ///< made from the convex hull, a box or a tetrahedron, not from the surface
};

/// Decides by exact arithmetic: the certificate of a candidate, no value if it is refused. Called from one thread.
using Accept = std::function<std::optional<Certificate>(const Candidate&)>;

struct LevelResult {
  Candidate candidate;
  Certificate certificate;       ///< what `accept` returned for the candidate
  TriangleMesh undeformed;       ///< of the flow: the coarse mesh before it was moved
  double flow_seconds = 0;       ///< 0 for the collapse
  double reinflate_seconds = 0;  ///< with the final minimisation; 0 for the collapse
};

}  // namespace encage::makers
