// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <vector>

namespace encage::makers {

struct FlowRequest {
  const TriangleMesh* fine = nullptr;    ///< F: any triangles; degenerate ones are fine
  const TriangleMesh* coarse = nullptr;  ///< C^: closed, oriented, embedded; stays where it is
  double diagonal = 0;                   ///< of the source, the unit of all limits
  double gap = 0;                        ///< distance that F must keep to C^ when it is inside, a length
  int most_steps = 300;
  int most_smoothings = 12;  ///< smoothings of stuck parts, the last resort
  int threads = 1;
  std::function<void()> check;  ///< called often; may throw to cancel
};

/// The path of F, newest step last; only what moved in a step is kept.
class FlowHistory {
 public:
  explicit FlowHistory(const Vertices& start) : start_(start) {}

  int steps() const { return static_cast<int>(steps_.size()); }
  void push(std::vector<std::int32_t> moved, std::vector<Eigen::Vector3f> positions);
  /// Appends the steps of a flow that began where this one ended.
  void append(const FlowHistory& later);
  /// F after `step` steps: 0 is where it started, exactly; later positions are float32.
  Vertices at(int step) const;
  std::size_t bytes() const;

 private:
  struct Step {
    std::vector<std::int32_t> moved;
    std::vector<Eigen::Vector3f> positions;
  };
  Vertices start_;
  std::vector<Step> steps_;
};

struct FlowResult {
  /// True if all of F lies inside C^ and keeps the gap, by the makers' conservative tests, on which no certificate
  /// relies; false if the flow stalled.
  bool inside = false;
  Vertices positions;  ///< F at the end; vertices that moved are float32
  FlowHistory history;
  int smoothing_steps = 0;          ///< of the flowing mesh, as a last resort
  std::vector<std::int32_t> stuck;  ///< if stalled: triangles of F that still touch C^ or lie outside
};

/// Moves F into C^ down the gradient of its signed distance: Nested Cages, section 3.1 and algorithm 2.
FlowResult flow(const FlowRequest& request);

}  // namespace encage::makers
