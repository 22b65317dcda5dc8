// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/contact/contact_solver.h"

#include <encage/mesh.h>

#include <cstdint>
#include <span>

namespace encage::makers {

/// One step of the coarse mesh away from the flowing F, up the gradient of F's signed distance (by winding number: F
/// may be a soup, and intersects itself while it flows), with contacts of the coarse mesh with itself: what Nested
/// Cages, section 3.1, proposes where the flow stalls. Faces that are not `gap` outside of F move, and those that the
/// `stuck` triangles of F cut through. `reach` limits the step.
TriangleMesh expand(const TriangleMesh& coarse, const TriangleMesh& flowed, std::span<const std::int32_t> stuck,
                    double gap, double reach, const ContactOptions& options);

}  // namespace encage::makers
