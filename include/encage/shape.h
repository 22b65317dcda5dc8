// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shapes of bodies, and the boxes and margins that follow from their motion.

#include <encage/asset.h>
#include <encage/cage.h>
#include <encage/export.h>
#include <encage/motion.h>

#include <Eigen/Geometry>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace ENCAGE_EXPORT encage {

/// The cages and the fine mesh of an asset with their trees in the body frame, ready for queries. Immutable; any number
/// of bodies and threads may share one.
class Shape;
using ShapePtr = std::shared_ptr<const Shape>;

struct ShapeOptions {
  /// True if the body is its surface alone, like a terrain or a sheet. Nothing is then inside it, and whatever lies
  /// within the surface without touching it is separated. Without this flag an open surface may have an interior, which
  /// is unknown, and the answer is "maybe" for anything in its convex hull. Usually false.
  bool hollow = false;
};

/// Builds the trees in O(n log n) for n triangles, single-threaded, and copies what it needs. Throws Error if the
/// hierarchy is malformed: no levels and no fine mesh, a cage that is empty or not closed, indices out of range,
/// coordinates that are not finite or not exact in float32, an origin beyond 1e150.
ShapePtr make_shape(const CageHierarchy& hierarchy, const ShapeOptions& options = {});

/// Makes a shape without cages, e.g. static terrain, from a mesh as it is, degenerate triangles included. The shape is
/// solid if no edge is open. Coordinates are rounded to float32 about a local origin; queries account for that. O(n log
/// n); throws Error as above, and for coordinates beyond 1e37.
ShapePtr make_shape(const TriangleMesh& mesh, const ShapeOptions& options = {});

/// Returns the same body with its vertices moved, for meshes that deform: the triangles, and the tree, whose boxes are
/// fitted to the new places. That takes a twentieth of the time of make_shape() or less; queries get slower as
/// triangles part that were neighbours in the tree (docs/performance.md). Make the shape anew after large changes.
/// `vertices` has one row for each vertex of the fine mesh, in the body frame. Cages would no longer enclose the mesh:
/// the result has none. Linear time. Throws Error for a compound, for a primitive (<encage/primitives.h>), for a shape
/// of a ShapeCache or without a fine mesh, for another number of vertices, and for coordinates that are not finite or
/// beyond 1e37. Any number of threads may refit one shape.
ShapePtr refit_shape(const Shape& shape, const Vertices& vertices);

/// Returns the same body stretched along the axes of its frame: x -> (scale_0 x_0, scale_1 x_1, scale_2 x_2). Negative
/// factors mirror: of an odd number of them the triangles are turned (corners 1 and 2 change places), so that outside
/// stays outside. Triangles and vertices keep their numbers. Motion::scale does equal factors for nothing.
///
/// Cages map to cages. Rounding to float32 moves them, so each is kept only if the clearance of its certificate is
/// larger than that, 1e-7 of the size, which it usually is. Cages that no longer keep their distance, or never had a
/// certificate, are left out. fine_error() grows by the largest factor and by rounding.
///
/// The parts of a compound get shapes of their own: their poses stay rigid, and what the factors do to a turned part,
/// shear included, is in its vertices. Rounding then counts as many times as much against the clearance as the factors
/// differ: by a hundred times without harm. Parts that share a shape and are stretched alike go on to share one.
///
/// Linear time, a tenth of that of make_shape(). Throws Error for a factor whose size is not between 1e-50 and 1e50,
/// for a primitive (<encage/primitives.h>), for a height field, for a shape of a ShapeCache with a fine mesh
/// (load_shape() reads one that can be stretched), for coordinates beyond 1e37, and if neither cages nor a fine mesh
/// are left. Any number of threads may stretch one shape.
ShapePtr scale_shape(const Shape& shape, const Eigen::Vector3d& scale);

/// Maps an asset and uses it in place, trees included. The file must not be overwritten or truncated while the shape
/// lives; it may be replaced or removed. LoadMode::copy reads the file into memory instead and then no longer needs it.
/// Throws Error naming file, section and reason. ShapeCache loads more assets than fit in memory.
ShapePtr load_shape(const std::filesystem::path& file, const ShapeOptions& options = {}, LoadMode mode = LoadMode::map);

/// A shape at its position in a compound: x -> pose * (scale * x).
struct CompoundPart {
  ShapePtr shape;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  double scale = 1;
};

/// Makes a body of several rigid parts, which may overlap: their union. The compound shares the parts' shapes;
/// compounds among the parts are replaced by their own parts. Triangles and vertices of the fine meshes are numbered
/// through all parts in order. A query costs as much as the parts near the other body cost. Throws Error naming the
/// part: no shape; a pose that is not finite, beyond 1e150 or farther than 1e-12 from rigid; a scale not between 1e-50
/// and 1e50; a part that reaches farther than 1e150. In nested compounds the same limits hold for the product of the
/// poses and scales, which may be 1e-10 from rigid. nearest_rigid() and pose_from() make poses that are rigid enough.
ShapePtr make_compound(std::span<const CompoundPart> parts);

std::int64_t part_count(const Shape& shape) noexcept;  ///< 1 for a simple shape

/// The part that contains a triangle of a compound, and the triangle's number in that part.
struct PartTriangle {
  std::int32_t part = 0;  ///< index after nested compounds have been replaced by their parts
  std::int32_t triangle = 0;
};
PartTriangle part_triangle(const Shape& shape, std::int32_t triangle) noexcept;

/// Returns the number of cages; for a compound, that of the part with the most. Level 0 is the finest.
int level_count(const Shape& shape) noexcept;

/// Returns the number of triangles of a cage, 0 <= level < level_count(shape). For a compound it is the sum over all
/// parts of the cage of that level, or the part's coarsest.
std::int64_t level_triangles(const Shape& shape, int level) noexcept;

/// Returns a bound, in world units and rounded up, of how far a point of the body leaves its straight path if the body
/// turns about its axis at uniform angular velocity: r (1 - cos(angle/2)), where r is the largest distance of a vertex
/// from the axis through `pivot` (body frame, before scaling), and `pivot` stays on its straight path. The bound is 0
/// for a motion without rotation, and for a ball that turns about its centre: of a primitive with a convex radius it is
/// that of the core, which carries the rest along. Add both bodies' bounds to a margin. The body turns the short way
/// (Motion). The bound is infinite if a pose is not finite, mirrors or is far from rigid.
double arc_margin(const Shape& shape, const Motion& motion,
                  const Eigen::Vector3d& pivot = Eigen::Vector3d::Zero()) noexcept;

/// Returns a bound, in the body frame and rounded up, of the distance of a point of the body from `pivot` (before
/// scaling). It comes from the balls about the local origins of the parts, so it is not the least bound.
double radius(const Shape& shape, const Eigen::Vector3d& pivot = Eigen::Vector3d::Zero()) noexcept;

/// Returns how far, in world units and rounded up, a correction of this RigidPose::deviation moves points of a body of
/// this scale: deviation * scale * radius(shape). Add it to a margin, and nothing is missed of what the body touches at
/// the matrix as it was given.
double correction_margin(const Shape& shape, double deviation, double scale = 1) noexcept;

/// Returns a world box that contains the body during the whole motion, rounding included, while every vertex moves on
/// its straight line (add arc_margin() for true rotation). It is not the smallest one, but the box of a cage with few
/// vertices, or of boxes around parts of the surface. It is the whole space if the motion is not usable.
Eigen::AlignedBox3d world_box(const Shape& shape, const Motion& motion) noexcept;

}  // namespace encage
