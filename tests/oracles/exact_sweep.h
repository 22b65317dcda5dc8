// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Time at which two moving meshes first touch, by brute force over their features in exact arithmetic.

#include "oracles/exact_ccd.h"

#include <encage/mesh.h>
#include <encage/shape.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace encage::test {

/// Triangles, degenerate ones included, whose vertices move linearly.
struct MovingMesh {
  Vertices start, end;
  Triangles triangles;
};

/// Returns a mesh on a body's motion: every vertex is the image of scale (origin + vertex), rounded (1e-15 of its
/// size).
MovingMesh moving_mesh(const Eigen::Vector3d& origin, const TriangleMesh& mesh, const Motion& motion);

/// Returns the pairs of triangles whose boxes are at most `distance` apart in some 32nd of the step.
std::vector<std::array<std::int64_t, 2>> close_triangles(const MovingMesh& a, const MovingMesh& b, double distance);

/// Returns the first time in [0, 1] at which the surfaces have a point in common; 0 if they have one at the start.
std::optional<TimeBounds> exact_first_contact(const MovingMesh& a, const MovingMesh& b);

/// True if there is such a time; takes less work than the time itself.
bool exact_contact(const MovingMesh& a, const MovingMesh& b);

/// Returns the first time at which the surfaces are at most `distance` + arc * 4 t (1 - t) apart, with the meaning and
/// the limits of the function of the same name for features.
std::optional<double> first_within(const MovingMesh& a, const MovingMesh& b, double distance, double arc,
                                   double resolution);

/// True if there is such a time for an arc of 0; takes less work than the time itself.
bool come_within(const MovingMesh& a, const MovingMesh& b, double distance, double resolution);

}  // namespace encage::test
