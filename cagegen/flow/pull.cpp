// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/pull.h"

#include <algorithm>
#include <cmath>

namespace encage::makers {

namespace {

// Balls tried along a path, and the part of it that may stay uncovered where it comes in.
constexpr int most_balls = 8;
constexpr double uncovered_part = 1.0 / 8;

}  // namespace

Pull pull(const SignedDistance& surface, const Corners& corners, const std::array<double, 3>& depth,
          const std::array<std::int32_t, 3>& start) {
  Pull result;
  for (int j = 0; j < 3; ++j) {
    const auto& lambda = quadrature_weights[j];
    const Nearest sample =
        surface.nearest(lambda[0] * corners[0] + lambda[1] * corners[1] + lambda[2] * corners[2], start[j]);
    const double missing = sample.distance + lambda[0] * depth[0] + lambda[1] * depth[1] + lambda[2] * depth[2];
    if (missing <= 0) continue;
    for (int k = 0; k < 3; ++k) {
      result.jump[k] += lambda[k] / 3 * missing * sample.direction;
      result.weight[k] += lambda[k] / 3;
    }
  }
  return result;
}

bool may_go(const SignedDistance& surface, const Point& p, const Nearest& at_p, const Point& y, const Nearest& at_y) {
  const bool inside_p = at_p.distance < 0;
  const bool inside_y = at_y.distance < 0;
  if (inside_p && !inside_y) return false;
  const double length = (y - p).norm();
  double covered = std::abs(at_p.distance);
  double end = length - std::abs(at_y.distance);
  const double rest = length * uncovered_part;
  Nearest ahead = at_p;
  Nearest back = at_y;
  for (int ball = 0; end - covered > rest; ++ball) {
    if (ball == most_balls) return false;
    ahead = surface.nearest(p + covered / length * (y - p), ahead.triangle);
    covered += std::abs(ahead.distance);
    if (end - covered <= rest) break;
    back = surface.nearest(p + end / length * (y - p), back.triangle);
    end -= std::abs(back.distance);
  }
  return true;
}

}  // namespace encage::makers
