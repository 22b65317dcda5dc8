// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/contact.h>

#include <optional>

namespace encage {

/// The distance that proves absence of contact: features are farther apart than `distance` + arc * 4 t (1 - t). It need
/// not include the rounding of the tests below.
struct Requirement {
  double distance = 0;
  double arc = 0;
  double latest = 1;
};

/// Returns a lower bound of the time of first contact between points[0] and the face of the other three: a multiple of
/// 2^-22; 0 if a number is not finite, or is negative where it must not be. The proof covers the rounding of this test;
/// `distance` must include that of the points themselves. Every `latest` gives the same answer, except that later
/// contacts are not reported. Adds the number of spans of time that it looked at to `spans`.
std::optional<double> first_vertex_face(const MovingPoints& points, const Requirement& required,
                                        std::int64_t& spans) noexcept;
std::optional<double> first_vertex_face(const MovingPoints& points, const Requirement& required) noexcept;

/// The same for the edges points[0] points[1] and points[2] points[3].
std::optional<double> first_edge_edge(const MovingPoints& points, const Requirement& required,
                                      std::int64_t& spans) noexcept;
std::optional<double> first_edge_edge(const MovingPoints& points, const Requirement& required) noexcept;

}  // namespace encage
