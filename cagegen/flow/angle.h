// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace encage::makers {

/// atan2 by additions, multiplications, divisions and roots only: libm's differ between machines (docs/architecture.md,
/// Determinism). Absolute error below 1e-14; 0 if both are 0.
inline double arc_tangent(double y, double x) {
  const double ax = std::abs(x);
  const double ay = std::abs(y);
  if (ax == 0 && ay == 0) return 0;
  double t = ay < ax ? ay / ax : ax / ay;
  // Halved twice, which leaves |t| <= tan(pi/16).
  for (int i = 0; i < 2; ++i) t = t / (1 + std::sqrt(1 + t * t));
  const double y2 = t * t;
  double sum = 0;
  for (const double divisor : {21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0, 1.0})
    sum = 1 / divisor - y2 * sum;
  double angle = 4 * t * sum;
  constexpr double quarter = 1.5707963267948966;
  if (ay >= ax) angle = quarter - angle;
  if (x < 0) angle = 2 * quarter - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace encage::makers
