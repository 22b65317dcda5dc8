// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/motion/pose.h"
#include "src/limits.h"

#include <encage/queries.h>

#include <array>

namespace encage {

using BoxCorners = std::array<Eigen::Vector3d, 8>;

/// Computes the corners of a box in the world, and bounds their rounding. False if the box is none.
inline bool corners_of(const OrientedBox& box, BoxCorners& corners, double& rounding) noexcept {
  if (!is_usable(box.pose) || !(box.half.minCoeff() >= 0) || !box.half.allFinite()) return false;
  for (unsigned i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    corners[i] = box.pose * Eigen::Vector3d(sign.cwiseProduct(box.half));
  }
  rounding = 16 * eps * (box.half.norm() + box.pose.translation().norm());
  return true;
}

}  // namespace encage
