// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/broadphase.h>
#include <encage/poses.h>

#include <cstdint>
#include <string>
#include <vector>

namespace encage::replay {

/// Numbers of two bodies, a < b.
struct BodyPair {
  std::int32_t a = 0, b = 0;
  friend auto operator<=>(const BodyPair&, const BodyPair&) = default;
};

/// Encage's cage test, to be asked before an engine tests triangles.
class CageGate {
 public:
  /// Asks one pair of cage levels, 0 the finest.
  CageGate(ShapePtr shape, int level);

  const ShapePtr& shape() const { return shape_; }
  int level() const { return level_; }
  /// Proven: the bodies do not touch.
  bool separated(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const;

 private:
  ShapePtr shape_;
  int level_;
};

/// A collision engine that holds copies of one mesh. It prepares what it can when it is made. Not for
/// use by several threads.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual std::string name() const = 0;
  /// Pairs of bodies whose surfaces touch or solids overlap at the poses of a step, sorted; found by the engine's
  /// own stages. If there is a gate, it is asked about each pair before the engine tests triangles.
  virtual std::vector<BodyPair> touching(const PoseStep& step, const CageGate* gate) = 0;
};

}  // namespace encage::replay
