// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shapes of bodies, their motion during a step, and the boxes and margins that follow from both.

#include <encage/asset.h>
#include <encage/cage.h>
#include <encage/export.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace ENCAGE_EXPORT encage {

/// What the run time needs of an asset: cages and fine mesh with their
/// body-frame trees. Immutable; shared by any number of bodies and threads.
class Shape;
using ShapePtr = std::shared_ptr<const Shape>;

struct ShapeOptions {
  /// The body is its surface alone, like a terrain or a sheet: nothing is inside it, and what lies within a closed or
  /// open surface without touching it is separated. Otherwise an open surface may have an interior, which nobody
  /// knows, and whatever is in its hull answers "maybe".
  bool hollow = false;
};

/// Builds the trees; O(n log n) for n triangles, single-threaded. Copies what it
/// needs. Throws Error if the hierarchy is malformed: nothing to test (no
/// levels and no fine mesh), a cage that is empty or not closed, indices out of
/// range, coordinates that are not finite or not exact in float32, an origin
/// beyond 1e150.
ShapePtr make_shape(const CageHierarchy& hierarchy, const ShapeOptions& options = {});

/// A shape without cages, e.g. static terrain: the mesh as it is, degenerate triangles and all. It is solid where no
/// edge is left open. Rounded to float32; queries account for that. O(n log n); throws Error as above.
ShapePtr make_shape(const TriangleMesh& mesh, const ShapeOptions& options = {});

/// Maps an asset and uses it in place, trees included; the file must not be overwritten or truncated
/// while the shape lives (replaced or removed it may be). LoadMode::copy reads it into memory instead and is done with
/// it. Throws Error naming file, section and reason. ShapeCache loads more assets than there is memory for.
ShapePtr load_shape(const std::filesystem::path& file, const ShapeOptions& options = {}, LoadMode mode = LoadMode::map);

/// A shape at its place in a compound: x -> pose * (scale * x).
struct CompoundPart {
  ShapePtr shape;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  double scale = 1;
};

/// A body of several rigid parts, which may overlap: their union. Shares the parts' shapes; compounds among them are
/// taken apart. Triangles and vertices of fine meshes count through all parts, in order. Queries cost what the parts
/// near the other body cost. Throws Error naming the part: no shape; a pose not finite, beyond 1e150 or farther than
/// 1e-12 from rigid; a scale not between 1e-50 and 1e50; a part that reaches farther than 1e150. In nests also what
/// they amount to: there 1e-10 from rigid.
ShapePtr make_compound(std::span<const CompoundPart> parts);

std::int64_t part_count(const Shape& shape) noexcept;  ///< 1 for what is no compound

/// Which triangle of which part a triangle of the whole is.
struct PartTriangle {
  std::int32_t part = 0;  ///< compounds among the parts having been taken apart
  std::int32_t triangle = 0;
};
PartTriangle part_triangle(const Shape& shape, std::int32_t triangle) noexcept;

/// Number of cages; of a compound, of the part that has most. Level 0 is the finest.
int level_count(const Shape& shape) noexcept;

/// Triangles of a cage, 0 <= level < level_count(shape); of all parts' cages of the level, or their coarsest.
std::int64_t level_triangles(const Shape& shape, int level) noexcept;

/// Rigid motion of the body frame (the frame of the source file) to the world, of a body at `scale` times its size:
/// x -> pose * (scale * x). Every vertex moves on the straight line between its two places.
struct Motion {
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d end = Eigen::Isometry3d::Identity();
  double scale = 1;  ///< > 0, the same throughout

  static Motion resting(const Eigen::Isometry3d& pose, double scale = 1) { return {pose, pose, scale}; }
  bool at_rest() const { return start.matrix() == end.matrix(); }
};

/// True if queries answer about this motion: both poses are finite, do not mirror and are within 1e-9 of rigid; the
/// rotation between them, taken the short way, is below 180 degrees (with 1e-6 to spare); the scale is between 1e-50 and
/// 1e50.
bool is_usable(const Motion& motion) noexcept;

/// Bound of how far a point of the body leaves its straight path if the body
/// really turns about its axis at uniform angular velocity: r (1 - cos(angle/2)), r the
/// largest distance of a vertex from the axis through `pivot` (body frame, before scaling) that stays on its straight
/// path. World units, rounded up; 0 for a motion without rotation. Add it to a margin for both bodies.
double arc_margin(const Shape& shape, const Motion& motion,
                  const Eigen::Vector3d& pivot = Eigen::Vector3d::Zero()) noexcept;

/// World box that contains the body during the whole motion, rounding included: not the
/// least one, but that of a cage with few vertices or of boxes around its parts. The whole space if the motion is not
/// usable.
Eigen::AlignedBox3d world_box(const Shape& shape, const Motion& motion) noexcept;

/// The solid { x : normal . x <= offset } of the world; normal of unit length within 1e-9.
struct HalfSpace {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;
};

}  // namespace encage
