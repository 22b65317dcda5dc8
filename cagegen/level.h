// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The makers of a level (CollapseMaker, ConvexMaker, FlowMaker) take a LevelRequest and give Candidates.

#include "cagegen/geometry/obstacle.h"
#include "cagegen/threads/control.h"

#include <encage/bake.h>
#include <encage/mesh.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace encage::makers {

/// Distance that a level keeps to itself, in clearances, for each level that must still fit between two of its strands,
/// and for itself.
constexpr double self_clearances_of_a_level = 3;

class WrapStarts;

struct LevelRequest {
  const TriangleMesh* inner = nullptr;               ///< what must be enclosed; the obstacle is made of it
  const TriangleMesh* clean = nullptr;               ///< the same surface without degenerate triangles
  bool manifold = false;                             ///< `clean` is a closed oriented manifold
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the local frame, for messages
  std::int64_t faces = 0;                            ///< at most
  double diagonal = 0;                               ///< of the source
  double clearance = 0;                              ///< least distance to the obstacle, a length
  double self_clearance = 0;                         ///< least distance between strands of the cage, a length
  Topology topology = Topology::any;
  WrapStarts* wraps = nullptr;                ///< of the obstacle, shared by the makers of a level
  int threads = 1;                            ///< never changes the result
  std::function<void(std::string_view)> log;  ///< what failed and what was tried instead; may be empty
};

/// No cage is much tighter than the finer surface itself, moved outward, and there are faces enough for that.
inline bool own_surface_suffices(const LevelRequest& request) {
  return request.manifold && request.topology != Topology::simplify && request.clean->triangles.rows() <= request.faces;
}

/// A cage that may become the level.
struct Candidate {
  TriangleMesh cage;
  double volume = 0;
  std::string start;  ///< "decimate", "wrap/50", "hull", "box", "tetrahedron", "regular", "adaptive", "user"
  Method method = Method::collapse;
  TriangleMesh undeformed;       ///< of the flow: the coarse mesh before it was moved
  double flow_seconds = 0;       ///< 0 for the collapse
  double reinflate_seconds = 0;  ///< 0 for the collapse
};

/// Makes cages for one level, a batch at a time, until one of them is certified.
class CandidateMaker {
 public:
  CandidateMaker() = default;
  virtual ~CandidateMaker() = default;
  CandidateMaker(const CandidateMaker&) = delete;
  CandidateMaker& operator=(const CandidateMaker&) = delete;

  /// The next cages, valid but not finished; none: there are no more. The same for any number of threads. Throws
  /// Cancelled.
  virtual std::vector<Candidate> next() = 0;
  /// None of them, finished, will enclose less.
  virtual double least_volume() { return 0; }
  /// Makes a candidate as tight as it can be with its faces.
  virtual void finish(Candidate& candidate) = 0;
  /// Moves the faces of a finished candidate to where they serve most.
  virtual void redistribute(Candidate& candidate) = 0;
  /// Why nothing came of the last attempt, in the user's words.
  virtual std::string failure() const = 0;
};

}  // namespace encage::makers
