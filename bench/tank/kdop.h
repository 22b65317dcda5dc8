// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/sweep.h"

#include <Eigen/Core>

#include <algorithm>
#include <array>

namespace encage::tank {

/// Discrete oriented polytope of 26 planes: the normals of a cube's faces, edges and corners, 13 pairs of opposite
/// ones. Rounded outward to float.
struct Kdop {
  static constexpr int pairs = 13;

  /// Largest n_k . x in the first half, largest -n_k . x in the second: all of it grows with the volume.
  std::array<float, 2 * pairs> reach;

  void extend(const Kdop& other) {
    for (int k = 0; k < 2 * pairs; ++k) reach[k] = reach[k] < other.reach[k] ? other.reach[k] : reach[k];
  }
  bool overlaps(const Kdop& other) const {
    int apart = 0;
    for (int k = 0; k < pairs; ++k) {
      apart |=
          static_cast<int>(reach[k] < -other.reach[k + pairs]) | static_cast<int>(other.reach[k] < -reach[k + pairs]);
    }
    return apart == 0;
  }
  /// Extent along a coordinate axis.
  float width(int axis) const { return reach[axis] + reach[axis + pairs]; }
  /// Twice the middle along a coordinate axis.
  float middle(int axis) const { return reach[axis] - reach[axis + pairs]; }
};

/// n_k . p for the 13 normals, which are not of unit length: the three axes first, then edges, then corners.
inline std::array<double, Kdop::pairs> kdop_projections(const Eigen::Vector3d& p) {
  const double x = p.x(), y = p.y(), z = p.z();
  return {x, y, z, x + y, x - y, x + z, x - z, y + z, y - z, x + y + z, x + y - z, x - y + z, x - y - z};
}

/// The polytope of the segment p q, enlarged by `slack` on all sides.
inline Kdop kdop_of(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double slack) {
  const std::array<double, Kdop::pairs> at_p = kdop_projections(p), at_q = kdop_projections(q);
  // Lengths of the normals, rounded up.
  const std::array<double, 3> by = {slack, 1.4143 * slack, 1.7321 * slack};
  Kdop dop;
  for (int k = 0; k < Kdop::pairs; ++k) {
    const double more = by[k < 3 ? 0 : k < 9 ? 1 : 2];
    dop.reach[k] = float_above(std::max(at_p[k], at_q[k]) + more);
    dop.reach[k + Kdop::pairs] = float_above(more - std::min(at_p[k], at_q[k]));
  }
  return dop;
}

}  // namespace encage::tank
