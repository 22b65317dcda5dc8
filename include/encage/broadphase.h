// SPDX-License-Identifier: Apache-2.0
#pragma once

// Run time: certified rejection of pairs. No CGAL, no allocation in queries.

#include <encage/cage.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <vector>

namespace encage {

/// What the run time needs of an asset: cages and fine mesh with their
/// body-frame trees. Immutable; shared by any number of bodies and threads.
class Shape;
using ShapePtr = std::shared_ptr<const Shape>;

/// Builds the trees. Throws Error if the hierarchy is malformed.
ShapePtr make_shape(const CageHierarchy& hierarchy);

/// Rigid motion of the body frame (the frame of the source file) to the world.
/// Every vertex moves on the straight line between its two places.
struct Motion {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d end = Eigen::Isometry3d::Identity();
};

/// The stage that gave a verdict, or the last one that was asked.
enum class Stage : std::uint8_t { box, cage, fine };

struct Verdict {
  bool separated = false;  ///< proven farther apart than the margin, rounding included
  Stage stage = Stage::box;
  std::int8_t level = -1;  ///< for Stage::cage: index of the cage level, 0 the finest
};

/// Proves that two posed bodies are farther apart than `margin` (>= 0, world
/// units), or answers "maybe". Re-entrant; never throws. Discrete: both motions
/// at rest (start == end); a moving pair answers "maybe" unless its boxes are
/// disjoint during the whole motion.
Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  double margin = 0) noexcept;

}  // namespace encage
