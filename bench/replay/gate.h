// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/poses.h>
#include <encage/separated.h>

#include <compare>
#include <cstdint>
#include <vector>

namespace encage::replay {

/// Numbers of two bodies, a < b.
struct BodyPair {
  std::int32_t a = 0, b = 0;
  friend auto operator<=>(const BodyPair&, const BodyPair&) = default;
};

/// In increasing order.
BodyPair make_pair(std::int32_t one, std::int32_t other);

/// A test in front of an engine's test of triangles.
class Gate {
 public:
  virtual ~Gate() = default;
  /// The bodies do not touch: the engine need not be asked. Says nothing of boxes, which the engine has compared.
  virtual bool separated(const BodyPose& a, const BodyPose& b) const = 0;
};

/// Encage's cages of one level, 0 the finest.
class CageGate : public Gate {
 public:
  CageGate(ShapePtr shape, int level);
  int level() const { return level_; }
  bool separated(const BodyPose& a, const BodyPose& b) const override;

 private:
  ShapePtr shape_;
  int level_;
};

/// Encage's trees of the fine mesh.
class FineGate : public Gate {
 public:
  explicit FineGate(ShapePtr shape);
  bool separated(const BodyPose& a, const BodyPose& b) const override;

 private:
  ShapePtr shape_;
};

/// Knows the pairs that touch: what a perfect test would gain.
class PerfectGate : public Gate {
 public:
  /// `touching` is sorted and outlives the gate.
  explicit PerfectGate(const std::vector<BodyPair>& touching) : touching_(touching) {}
  bool separated(const BodyPose& a, const BodyPose& b) const override;

 private:
  const std::vector<BodyPair>& touching_;
};

}  // namespace encage::replay
