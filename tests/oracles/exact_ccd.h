// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Time at which linearly moving features first touch, in exact arithmetic: algebraic times, every degeneracy.

#include <encage/contact.h>

#include <cstdint>
#include <optional>

namespace encage::test {

enum class Features : std::uint8_t { vertex_face, edge_edge };

/// Bounds of a time, at most 2^-60 apart except for their rounding to doubles.
struct TimeBounds {
  double low = 0, high = 0;
};

/// Returns the first time in [0, 1] at which the closed features of finite points have a point in common: points[0] and
/// the triangle of the others, or the segments points[0] points[1] and points[2] points[3], any of them degenerate or
/// not. Takes about 1 us if intervals prove that there is none.
std::optional<TimeBounds> exact_first_contact(Features kind, const MovingPoints& points);

/// The same for distances at most `distance` + arc * 4 t (1 - t), by subdivision in long double to spans of
/// `resolution`. There is no value only if there is no such time. The features at a reported time are farther apart
/// than that by at most `resolution` times twice their largest speed.
std::optional<double> first_within(Features kind, const MovingPoints& points, double distance, double arc,
                                   double resolution);

}  // namespace encage::test
