// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "broadphase/separation/leaf_gate.h"

namespace encage::test {

/// lanes_not_apart() for one triangle each.
inline bool lanes_apart(const MovingTriangle& a, const MovingTriangle& b, int ends, double distance) {
  LeafLanes lanes_a, lanes_b;
  for (int lane = 0; lane < LeafLanes::width; ++lane) {
    lanes_a.set(lane, a, ends);
    lanes_b.set(lane, b, ends);
  }
  return lanes_not_apart(lanes_a, 0, lanes_b, 1, ends, distance) == 0;
}

}  // namespace encage::test
