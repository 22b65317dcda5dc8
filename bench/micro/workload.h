// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What the micro benches work on: a shape, and steps in which bodies of that shape come near each other.

#include "broadphase/separation/triangle_pair.h"

#include <encage/separated.h>

#include <filesystem>
#include <memory>
#include <vector>

namespace encage::micro {

/// Two bodies during a step, their world boxes not apart.
struct Case {
  Motion a, b;

  /// Both at rest, where they start.
  Case at_rest() const { return {Motion::resting(a.start), Motion::resting(b.start)}; }
};

struct TrianglePairCase {
  MovingTriangle a, b;
};

struct Workload {
  ShapePtr shape;
  std::filesystem::path asset;      ///< of the shape; of the sample, with another cage
  std::shared_ptr<void> temporary;  ///< removes the asset, if it is not the user's
  std::vector<Motion> bodies;       ///< of all steps
  std::vector<Case> cases;
};

/// Torus of 8,192 triangles with three cages, in random places near contact; the same in every run.
Workload sample_workload();

/// Bodies of the asset, in some steps spread evenly over the poses. Throws Error.
Workload recorded_workload(const std::filesystem::path& asset, const std::filesystem::path& poses);

/// Triangles of pairs of leaves that the box gate leaves over, some of every case.
std::vector<TrianglePairCase> near_triangles(const Workload& workload);

}  // namespace encage::micro
