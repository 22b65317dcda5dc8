// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/flow/signed_distance.h"

#include <array>
#include <cstdint>

// The integral that the flow decreases, and the path a vertex may take.

namespace encage::makers {

/// Barycentric coordinates of the second-order quadrature points of a triangle; each weighs a third of it.
inline constexpr std::array<std::array<double, 3>, 3> quadrature_weights{
    {{2.0 / 3, 1.0 / 6, 1.0 / 6}, {1.0 / 6, 2.0 / 3, 1.0 / 6}, {1.0 / 6, 1.0 / 6, 2.0 / 3}}};

/// What one triangle of weight 1 asks of its corners f: the sums over its quadrature points p that miss their depth m,
/// weights w = 1/3, of w λ_f (sd + m) g (the Newton jumps of the points, g as in eq. 6) and of w λ_f. `jump` is half
/// the gradient of the sum of w (sd + m)^2.
struct Pull {
  std::array<Point, 3> jump{Point::Zero(), Point::Zero(), Point::Zero()};
  std::array<double, 3> weight{};
};

/// `depth` is wanted at the corners, and linear between them. `start` as for SignedDistance::nearest().
Pull pull(const SignedDistance& surface, const Corners& corners, const std::array<double, 3>& depth,
          const std::array<std::int32_t, 3>& start);

/// Whether a vertex may go from p to y: it stays on its side, or comes in through the surface. No path leads out.
///
/// Around every point x there is a ball of radius |sd(x)| with no surface in it. Balls along the segment from p on and
/// from y back, each centred where the last one ended, cover the segment but for one interval, which holds all
/// crossings. It must shrink to 1/8 of the segment. So a path cannot pass through one part of C^ into another, unless
/// both walls and all between them are thinner than that along the path.
bool may_go(const SignedDistance& surface, const Point& p, const Nearest& at_p, const Point& y, const Nearest& at_y);

}  // namespace encage::makers
