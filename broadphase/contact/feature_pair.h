// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/contact.h>

#include <optional>

namespace encage {

/// What proves absence of contact: features farther apart than
/// `distance` + arc * 4 t (1 - t). The rounding of the tests below need not be part of it.
struct Requirement {
  double distance = 0;
  double arc = 0;
  double latest = 1;
};

/// First contact of points[0] and the face of the others: a lower bound of its
/// time, a multiple of 2^-22; 0 if a number is not finite or negative where it must not
/// be. The proof covers the rounding of this test; that of the points themselves
/// belongs in `distance`. Same answer for every `latest`, but for the cut.
std::optional<double> first_vertex_face(const MovingPoints& points, const Requirement& required) noexcept;

/// The same for the edges points[0] points[1] and points[2] points[3].
std::optional<double> first_edge_edge(const MovingPoints& points, const Requirement& required) noexcept;

}  // namespace encage
