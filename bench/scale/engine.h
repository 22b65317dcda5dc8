// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/scale/scene.h"

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
class Engine {
 public:
  virtual ~Engine() = default;

  /// Tells the engine what has moved and appends all pairs of bodies whose boxes overlap or touch, in
  /// double precision, each once, in any order.
  virtual void step(const Frame& frame, std::vector<PairKey>& pairs) = 0;

 protected:
  static bool overlap(const Frame& frame, std::uint32_t a, std::uint32_t b) {
    return frame.box[a].intersects(frame.box[b]);
  }
};

struct EngineKind {
  std::string name;
  std::string about;
  std::int64_t most_bodies;  ///< that it is asked about: beyond, it takes minutes
  bool boxes_only;           ///< finds all pairs of boxes; otherwise, those of bodies
  std::unique_ptr<Engine> (*make)(const Scene& scene);
};

/// All of them, Encage first.
const std::vector<EngineKind>& engine_kinds();
const EngineKind& engine_kind(const std::string& name);  ///< throws Error

std::unique_ptr<Engine> make_encage(const Scene& scene);
std::unique_ptr<Engine> make_encage_full(const Scene& scene);
std::unique_ptr<Engine> make_bullet_dbvt(const Scene& scene);
std::unique_ptr<Engine> make_bullet_sweep(const Scene& scene);
std::unique_ptr<Engine> make_fcl_tree(const Scene& scene);
std::unique_ptr<Engine> make_fcl_tree_array(const Scene& scene);
std::unique_ptr<Engine> make_fcl_hash(const Scene& scene);
std::unique_ptr<Engine> make_fcl_ssap(const Scene& scene);
std::unique_ptr<Engine> make_embree(const Scene& scene);
std::unique_ptr<Engine> make_cgal(const Scene& scene);

}  // namespace encage::scale
