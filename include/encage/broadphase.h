// SPDX-License-Identifier: Apache-2.0
#pragma once

// Run time: certified rejection of pairs. No CGAL, no allocation in queries.

#include <encage/cage.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>

namespace encage {

/// What the run time needs of an asset: cages and fine mesh with their
/// body-frame trees. Immutable; shared by any number of bodies and threads.
class Shape;
using ShapePtr = std::shared_ptr<const Shape>;

/// Builds the trees; O(n log n) for n triangles, single-threaded. Copies what it
/// needs. Throws Error if the hierarchy is malformed: nothing to test (no
/// levels and no fine mesh), a cage that is empty or not closed, indices out of
/// range, coordinates that are not finite or not exact in float32.
ShapePtr make_shape(const CageHierarchy& hierarchy);

/// Number of cages. Level 0 is the finest.
int level_count(const Shape& shape) noexcept;

/// Triangles of a cage, 0 <= level < level_count(shape).
std::int64_t level_triangles(const Shape& shape, int level) noexcept;

/// Rigid motion of the body frame (the frame of the source file) to the world.
/// Every vertex moves on the straight line between its two places.
struct Motion {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d end = Eigen::Isometry3d::Identity();

  static Motion resting(const Eigen::Isometry3d& pose) { return {pose, pose}; }
  bool at_rest() const { return start.matrix() == end.matrix(); }
};

/// The stage that gave a verdict, or the last one that was asked.
enum class Stage : std::uint8_t {
  box,   ///< axis-aligned world boxes of the bodies
  cage,  ///< a pair of cages
  fine,  ///< the fine meshes
};

struct Verdict {
  bool separated = false;  ///< proven farther apart than the margin, rounding included
  Stage stage = Stage::box;
  std::int16_t level = -1;  ///< for Stage::cage: index of the cage level, 0 the finest
};

/// World box that contains the body during the whole motion, rounding included:
/// the box of the fine mesh, or of the finest cage if the asset has no fine
/// mesh. The whole space if a pose is not finite or farther than 1e-9 from rigid.
Eigen::AlignedBox3d world_box(const Shape& shape, const Motion& motion) noexcept;

/// Proves that two posed bodies are farther apart than `margin` (>= 0, world
/// units), or answers "maybe". Asks the stages in order: boxes, cages from
/// coarse to fine, fine meshes; the first proof ends the test. With different
/// numbers of levels, level k is tested on each body's level k or its coarsest.
///
/// Re-entrant; never throws, never allocates. Discrete: both motions at rest
/// (start == end); a moving pair answers "maybe" unless its boxes are apart
/// during the whole motion. A pose farther than 1e-9 from rigid answers "maybe".
///
/// A closed or capped body is its surface and the points of non-zero winding
/// number. A `surface_only` body is its surface; as its interior is unknown,
/// another body of which a connected part lies wholly in its convex hull answers
/// "maybe". docs/guarantee.md
/// proves each stage.
Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  double margin = 0) noexcept;

}  // namespace encage
