// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/geometry/separation.h"

#include <cstdint>

namespace encage::makers {

/// Part of a triangle: its inside, an edge (from corner k to k + 1), or a corner.
enum class Feature : std::uint8_t { face, edge0, edge1, edge2, corner0, corner1, corner2 };

struct ClosestPoint {
  Point point;
  double distance2 = 0;
  Feature feature = Feature::face;
};

/// The closest point of a triangle, in double. Thin and degenerate triangles count as segments or points, and cost
/// more.
ClosestPoint closest_point(const Point& p, const Corners& t, bool thin);

/// Whether the triangle's smallest angle is so small that closest_point() must take more care.
bool is_thin(const Corners& t);

}  // namespace encage::makers
