// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/certify/exact.h"

namespace encage::proof {

// Distances in double with proven error bounds. The idea: whatever direction d is tried, the gap between the
// projections of two convex sets on d is at most their distance. The way d was found, and the conditioning of slivers,
// decide how tight the bound is, never whether it holds. docs/certificate.md derives the error term.

/// Lower bound of a distance from a computed gap. `gap` is the difference of two projections on a vector that was
/// normalised in double, of points given relative to a common base; `extent` is the largest coordinate, in magnitude,
/// of those relative points. 0 if nothing is proven, or only something near the end of the range of double.
inline double certain_distance(double gap, double extent) {
  const double bound = gap - 0x1p-47 * extent;
  return bound > 1e-280 ? bound : 0;
}

struct Separation {
  double lower = 0;  ///< proven lower bound of the distance; 0: nothing is proven
  double upper = 0;  ///< the distance up to rounding, or more; proves nothing
};

/// Two triangles, degenerate or not.
Separation separate(const Corners& a, const Corners& b);

/// Lower bound of the distance of two triangles from their projections on one direction.
double gap_along(const Point& direction, const Corners& a, const Corners& b);

}  // namespace encage::proof
