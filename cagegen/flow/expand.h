// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/contact/contact_solver.h"

#include <encage/mesh.h>

#include <cstdint>
#include <span>

namespace encage::makers {

/// Moves the coarse mesh one step away from the flowing F, as Nested Cages, section 3.1, proposes where the flow
/// stalls: up the gradient of F's signed distance, with contacts of the coarse mesh with itself. The sign comes from
/// winding numbers, since F may be a soup and intersects itself while it flows. Faces move that are not `gap` outside
/// of F, or that `stuck` triangles of F cut through. `reach` limits the step, a length.
TriangleMesh expand(const TriangleMesh& coarse, const TriangleMesh& flowed, std::span<const std::int32_t> stuck,
                    double gap, double reach, const ContactSolverOptions& options);

}  // namespace encage::makers
