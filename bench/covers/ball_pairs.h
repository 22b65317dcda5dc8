// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/covers/ball_cover.h"

namespace encage::covers {

/// To the common frame of a pair at both ends of a step.
struct BallMaps {
  explicit BallMaps(const std::array<AffineMap, 2>& maps);

  std::array<std::array<std::array<float, 3>, 3>, 2> linear;  ///< [end][row]
  std::array<std::array<float, 3>, 2> offset;
};

struct BallGate {
  BallGate(const std::array<AffineMap, 2>& maps_a, const std::array<AffineMap, 2>& maps_b, int number_of_ends,
           float required)
      : a(maps_a), b(maps_b), ends(number_of_ends), gap(required) {}

  BallMaps a, b;
  int ends;   ///< 1: both at rest
  float gap;  ///< distance of balls as computed that proves separation
};

/// Whether every pair of last balls is proven apart.
bool balls_apart(const BallCover& a, const BallCover& b, const BallGate& gate);

}  // namespace encage::covers
