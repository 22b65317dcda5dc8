// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/contact/contact_solver.h"
#include "cagegen/flow/flow.h"

#include <encage/bake.h>
#include <encage/energy.h>

#include <functional>
#include <string>

namespace encage::makers {

struct ReinflateRequest {
  const TriangleMesh* fine = nullptr;  ///< F at its home position
  const TriangleMesh* rest = nullptr;  ///< C^, with the solver's triangles
  const FlowResult* flowed = nullptr;  ///< F inside C^, and how it got there
  const CageEnergy* energy = nullptr;  ///< minimised in every step
  FlowPath path = FlowPath::straight;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of the local frame, for messages
  std::function<void(double fraction)> progress;     ///< may be empty
};

struct ReinflateResult {
  bool reached = false;
  int steps = 0;        ///< of F that the cage followed
  int halvings = 0;     ///< steps that were too long
  int slow_steps = 0;   ///< of the robust solver
  int reliefs = 0;      ///< times the cage was relaxed where it had jammed
  std::string failure;  ///< if not reached: where and why
};

/// Moves F from inside C^ back home, as an obstacle of infinite mass, while the cage gives way: Nested Cages, section 3.2
/// and algorithm 3. `solver` holds C^, valid around the flowed F; it ends valid around `home`, or around F somewhere on
/// the way if that is not reached.
ReinflateResult reinflate(ContactSolver& solver, const ReinflateRequest& request, const Obstacle& home);

}  // namespace encage::makers
