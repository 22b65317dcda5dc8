// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/separation.h"

namespace encage::makers {

/// Closest points of two disjoint triangles, as barycentric weights of their corners.
struct ClosestPair {
  double distance2 = 0;
  std::array<double, 3> weight_s{};
  std::array<double, 3> weight_t{};
};

ClosestPair closest_points(const Corners& s, const Corners& t);

}  // namespace encage::makers
