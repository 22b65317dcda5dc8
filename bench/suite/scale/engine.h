// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/suite/scale/scene.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace encage::scale {

/// Two bodies, the one with the smaller number in the upper half.
using PairKey = std::uint64_t;

inline PairKey pair_key(std::uint32_t a, std::uint32_t b) {
  return a < b ? PairKey{a} << 32 | b : PairKey{b} << 32 | a;
}

/// A broad phase that knows all bodies of a scene.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  /// Tells the engine what has moved and appends all pairs of bodies whose boxes overlap or touch, in double precision,
  /// each once, in any order.
  virtual void step(const ScaleFrame& frame, std::vector<PairKey>& pairs) = 0;

 protected:
  static bool overlap(const ScaleFrame& frame, std::uint32_t a, std::uint32_t b) {
    return frame.box[a].intersects(frame.box[b]);
  }
};

struct BroadPhaseKind {
  std::string name;
  std::string about;
  std::int64_t most_bodies;  ///< that it is asked about: beyond, it takes minutes
  bool boxes_only;           ///< finds all pairs of boxes; otherwise, those of bodies
  std::unique_ptr<BroadPhase> (*make)(const ScaleScene& scene);
};

/// All of them, Encage first.
const std::vector<BroadPhaseKind>& broad_phase_kinds();
const BroadPhaseKind& broad_phase_kind(const std::string& name);  ///< throws Error

std::unique_ptr<BroadPhase> make_encage(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_encage_full(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_bullet_dbvt(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_bullet_sweep(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_fcl_tree(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_fcl_tree_array(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_fcl_hash(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_fcl_ssap(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_embree(const ScaleScene& scene);
std::unique_ptr<BroadPhase> make_cgal(const ScaleScene& scene);

}  // namespace encage::scale
