// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/contact/contact_solver.h"

#include <encage/energy.h>
#include <encage/mesh.h>

#include <cstdint>
#include <functional>

namespace encage::makers {

struct MinimizeRequest {
  const TriangleMesh* fine = nullptr;  ///< what the cage encloses, as the energy sees it
  const TriangleMesh* rest = nullptr;  ///< C^, with the cage's triangles
  const CageEnergy* energy = nullptr;
  int iterations = 40;
  double enough = 0.01;               ///< stop when a step gains less than this share of what all have gained
  std::int64_t face_tests = 120'000;  ///< the budget
  std::function<void(double fraction)> progress;  ///< may be empty
};

/// The energy's descent; throws Error, which names the energy, if it lacks rows or is not finite.
Vertices checked_descent(const CageEnergy& energy, const EnergyState& state);

/// Projected gradient descent of the energy around an obstacle at rest: Nested Cages, algorithm 3, with the QP of
/// ContactSolver as its filter. The energy never grows, and every state on the way is valid.
void minimize(ContactSolver& solver, const Obstacle& obstacle, const MinimizeRequest& request);

/// The same for the volume, with cage as its own rest. The result encloses no more than `cage`.
TriangleMesh shrink(const Obstacle& obstacle, const TriangleMesh& cage, const ContactSolverOptions& options,
                    int iterations = 40);

}  // namespace encage::makers
