// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/contact/contact_search.h"

#include <encage/manifold.h>

#include <span>
#include <vector>

namespace encage {

/// Working memory of reduce_contacts(), per candidate.
struct ReductionEntry {
  bool kept = false;  ///< chosen in the step before
  double spread = 0;  ///< squared distance to the nearest point chosen
};

/// Chooses few points that act like all: the deepest, and those farthest from the ones chosen, in position and normal.
/// Features of the step before, `before` in their order, are preferred and keep their order, new ones follow. Points
/// are grouped in patches of similar normals. Candidates are relative to `origin`, and are sorted. Returns the number
/// of points.
int reduce_contacts(std::vector<ContactCandidate>& candidates, const ManifoldOptions& options,
                    const Eigen::Vector3d& origin, std::span<const std::uint64_t> before,
                    std::vector<ReductionEntry>& entries, std::span<ManifoldPoint> points);

}  // namespace encage
