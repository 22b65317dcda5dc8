// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>
#include <encage/poses.h>

#include <cstdint>

namespace encage::tank {

/// Number of pairs of bodies whose surfaces have a point in common, by exact predicates on the world coordinates
/// rounded to double: at most 2^-50 of the largest coordinate away from where they are. Shares no code with the
/// detection. All bodies are copies of `mesh`, of which no triangle may be degenerate.
std::int64_t interpenetrations(const TriangleMesh& mesh, const PoseStep& step);

}  // namespace encage::tank
