// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/certify/exact.h"

namespace encage::proof {

// Distances in double with proven error bounds. The idea: whatever direction d is tried, the gap between the
// projections of two convex sets on d is at most their distance. How d was found, and how badly a sliver conditions it,
// decides how tight the bound is, never whether it is true. docs/certificate.md derives the error term.

/// Lower bound of a distance from a computed gap. `gap` is the difference of two projections on a vector that was
/// normalised in double, of points given relative to a common base; `extent` is the largest coordinate, in magnitude,
/// of those relative points. 0 if nothing is proven, or only something near the end of the range of double.
inline double certain_distance(double gap, double extent) {
  const double bound = gap - 0x1p-47 * extent;
  return bound > 1e-280 ? bound : 0;
}

struct Separation {
  double lower = 0;  ///< proven: the distance is at least this (0: nothing is proven)
  double upper = 0;  ///< about the distance, not smaller save for rounding; proves nothing
};

/// Two triangles, degenerate or not.
Separation separate(const Corners& a, const Corners& b);

/// What projecting on one direction proves about the distance of two triangles.
double gap_along(const Point& direction, const Corners& a, const Corners& b);

}  // namespace encage::proof
