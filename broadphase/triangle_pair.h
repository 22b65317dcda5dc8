// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

namespace encage {

using TriangleD = std::array<Eigen::Vector3d, 3>;

/// True only if some axis separates the projections of the triangles by more
/// than `distance` > 0. Any axis gives a sound proof, whatever rounding did to
/// it; `distance` has to cover the rounding of projections (4 eps times the
/// largest norm of a corner, for each triangle). The axes tried suffice in
/// exact arithmetic: whichever features are closest, face and vertex, two
/// edges, or edge ends, their direction is among them. Degenerate triangles are allowed.
bool triangles_apart(const TriangleD& a, const TriangleD& b, double distance) noexcept;

}  // namespace encage
