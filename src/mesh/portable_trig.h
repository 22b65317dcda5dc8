// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace encage {

/// Sine and cosine of an angle given in full turns. It uses additions and multiplications only, because libm's results
/// differ between machines and every machine has to write the same bytes. The absolute error is below 1e-12 for |turns|
/// < 1e6; multiples of a quarter are exact.
struct SinCos {
  double sin = 0;
  double cos = 1;
};

inline SinCos sincos_turns(double turns) {
  const double quarters = std::floor(turns * 4 + 0.5);
  const double x = (turns - quarters * 0.25) * 6.283185307179586;  // |x| <= pi/4
  const double y = x * x;
  // Taylor series: the first omitted terms are below (pi/4)^15 / 15! and (pi/4)^16 / 16!.
  double s = 1;
  for (const double divisor : {156.0, 110.0, 72.0, 42.0, 20.0, 6.0}) s = 1 - y / divisor * s;
  double c = 1;
  for (const double divisor : {182.0, 132.0, 90.0, 56.0, 30.0, 12.0, 2.0}) c = 1 - y / divisor * c;
  s *= x;
  switch (static_cast<int>(quarters - 4 * std::floor(quarters / 4))) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

}  // namespace encage
