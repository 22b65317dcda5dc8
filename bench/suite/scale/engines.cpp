// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/scale/engine.h"

#include <encage/error.h>

namespace encage::scale {

const std::vector<BroadPhaseKind>& broad_phase_kinds() {
  constexpr std::int64_t any = 10'000'000, few = 10'000;
  static const std::vector<BroadPhaseKind> kinds = {
      {"encage", "World, boxes only, computed from the motions", any, true, make_encage},
      {"encage_full", "World, boxes and the bodies' own trees", any, false, make_encage_full},
      {"bullet", "btDbvtBroadphase", any, true, make_bullet_dbvt},
      {"bullet_sweep", "bt32BitAxisSweep3", few, true, make_bullet_sweep},
      {"fcl", "DynamicAABBTreeCollisionManager", any, true, make_fcl_tree},
      {"fcl_array", "DynamicAABBTreeCollisionManager_Array", any, true, make_fcl_tree_array},
      {"fcl_hash", "SpatialHashingCollisionManager", any, true, make_fcl_hash},
      {"fcl_ssap", "SSaPCollisionManager", few, true, make_fcl_ssap},
      {"embree", "a tree by Morton codes in each step, rtcCollide", any, true, make_embree},
      {"cgal", "box_self_intersection_d in each step", any, true, make_cgal},
  };
  return kinds;
}

const BroadPhaseKind& broad_phase_kind(const std::string& name) {
  for (const BroadPhaseKind& kind : broad_phase_kinds()) {
    if (kind.name == name) return kind;
  }
  throw Error("there is no engine \"" + name + "\"");
}

}  // namespace encage::scale
