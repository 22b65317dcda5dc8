// SPDX-License-Identifier: Apache-2.0
#pragma once

// Queries of one posed body: rays, nearest points, points in solids, and overlap with simple volumes.

#include <encage/export.h>
#include <encage/shape.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

// Of primitives with a convex radius (<encage/primitives.h>) queries are about their surface; triangles and features
// are those of the core that are nearest. Their convex radius counts with 1e-8 of itself as rounding, but for rays.
//
// Every query takes a body at the start of its motion: Motion::resting(pose, scale) for one that rests. Queries are
// about the fine mesh. They are re-entrant and never throw. They never allocate, except that a ShapeCache may have to
// read a fine mesh. The same calls give the same bits on every instruction set. A call about many rays or points gives
// what single calls give, in less time, and keeps the mesh of a simple shape of a ShapeCache until it returns.
//
// Let S be the sum of |translation|, of the scaled body's reach from the origin of its frame, and of the norm of the
// point, or of the ray's origin. Positions are rounded by at most 1e-13 S: the *rounding* below.
namespace ENCAGE_EXPORT encage {

// ---- Rays ----------------------------------------------------------------------

/// The points origin + t * direction with t_min <= t <= t_max.
struct Ray {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();        ///< world; coordinates up to 1e150
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();    ///< world; finite, not 0, of any length
  double t_min = 0;                                        ///< may be negative
  double t_max = std::numeric_limits<double>::infinity();  ///< no ray if it is below t_min
};

enum class BackFaces : std::uint8_t {
  hit,     ///< triangles count from both sides
  ignore,  ///< a triangle that is proven to be seen from behind does not count
};

struct RayOptions {
  BackFaces back_faces = BackFaces::hit;
};

struct RayHit {
  double t = 0;                                      ///< in units of the direction, between t_min and t_max
  std::int32_t triangle = -1;                        ///< numbered as in CageHierarchy::fine
  std::array<double, 3> barycentric = {1, 0, 0};     ///< weights of the corners: >= 0, their sum is 1 up to rounding
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< world, unit length; 0 of a degenerate triangle
  bool back_face = false;                            ///< the ray meets the side that the normal leads away from
};

enum class RayAnswer : std::uint8_t {
  miss,     ///< proven, rounding included
  hit,      ///< the ray comes within rounding of the triangle
  unknown,  ///< nothing is proven: see cast_ray()
};

struct RayResult {
  RayAnswer answer = RayAnswer::unknown;
  RayHit hit;  ///< for RayAnswer::unknown only `t` is set: no hit is earlier
};

/// Finds the first triangle of the fine mesh that a ray meets. The test is watertight (compare Woop et al. 2013,
/// "Watertight ray/triangle intersection"): no ray that meets the mesh is missed, not on edges and vertices, nor along
/// the plane of a triangle. A ray that passes a triangle within the rounding may hit. Degenerate triangles are hit as
/// the segments and points that they are. `hit.t` is off by the rounding divided by |direction| and by the sine of the
/// angle between ray and triangle. Of several hits with the same t the first in the mesh counts.
///
/// A ray enters a primitive with a convex radius at most once, and leaves it at most once, seen from behind. The normal
/// is that of the surface; triangle and weights are those of the nearest point of the core. Such a ray takes time
/// proportional to the number of vertices of the core. The answer is unknown where the search has not come to an end.
///
/// A body without a fine mesh, or one whose mesh a ShapeCache cannot read, is what its finest cage encloses: the answer
/// is a miss if the ray stays outside of that, else unknown. It is unknown, with t = t_min, if the start pose is not
/// usable, the direction is 0 or a number is not finite (t_min and t_max may be infinite) or too large.
RayResult cast_ray(const Shape& shape, const Motion& motion, const Ray& ray, const RayOptions& options = {}) noexcept;

/// cast_ray() for many rays: results[i] answers rays[i]. If the spans differ in length, the longer one's rest is
/// ignored.
void cast_rays(const Shape& shape, const Motion& motion, std::span<const Ray> rays, std::span<RayResult> results,
               const RayOptions& options = {}) noexcept;

struct RayHits {
  RayAnswer answer = RayAnswer::unknown;
  std::int64_t count = 0;  ///< of all hits, also those for which the span had no room
};

/// Finds all triangles that a ray meets, by increasing t and triangle. A ray through an edge or a vertex meets every
/// triangle there. If there are more hits than `hits` has room for, it gets the first ones. Where the answer is
/// RayAnswer::unknown, `count` is 0. Takes time proportional to hits.size() for each hit beyond.
RayHits all_hits(const Shape& shape, const Motion& motion, const Ray& ray, std::span<RayHit> hits,
                 const RayOptions& options = {}) noexcept;

/// Calls visit(context, hit) for all triangles that a ray meets, in a fixed order that is not that of t, until it
/// returns false. The answer is `hit` if there was a call. What the visitor throws is passed on.
RayAnswer visit_hits(const Shape& shape, const Motion& motion, const Ray& ray, const RayOptions& options,
                     bool (*visit)(void* context, const RayHit& hit), void* context);
/// visit_hits() with visit(const RayHit&) -> bool.
template <class Visit>
RayAnswer for_each_hit(const Shape& shape, const Motion& motion, const Ray& ray, const RayOptions& options,
                       Visit&& visit) {
  return visit_hits(
      shape, motion, ray, options,
      [](void* context, const RayHit& hit) { return (*static_cast<std::remove_reference_t<Visit>*>(context))(hit); },
      const_cast<void*>(static_cast<const void*>(&visit)));
}

// ---- Points --------------------------------------------------------------------

enum class PointSide : std::uint8_t {
  outside,  ///< proven
  inside,   ///< proven
  unknown,  ///< within rounding or CageHierarchy::fine_error of the surface, or in a body with an unknown interior
};

/// Tells whether a point lies in the solid of a body: the points about which its surface has a winding number other
/// than 0; of a compound, the union of its parts' solids. Both answers are proven for the body as it was baked. Nothing
/// is inside a hollow body. Of a Solid::surface_only body the answer is outside or unknown, and so it is of a body
/// without a fine mesh. It is unknown if the start pose is not usable or the point is not finite.
PointSide contains(const Shape& shape, const Motion& motion, const Eigen::Vector3d& point) noexcept;

/// contains() for many points: sides[i] answers points[i]. If the spans differ in length, the longer one's rest is
/// ignored.
void contains(const Shape& shape, const Motion& motion, std::span<const Eigen::Vector3d> points,
              std::span<PointSide> sides) noexcept;

/// What a nearest point lies on.
enum class SurfaceFeature : std::uint8_t {
  face,    ///< the inside of the triangle
  edge,    ///< the edge from corner `corner` of the triangle to the next one
  vertex,  ///< corner `corner` of the triangle
};

struct ClosestPoint {
  /// World units: lower <= distance <= upper, to the surface as it was baked. They differ by twice the rounding and
  /// CageHierarchy::fine_error. If no point of the surface is below the limit, `lower` is at least the limit less
  /// their half difference, and `upper` is infinite.
  double lower = 0;
  double upper = std::numeric_limits<double>::infinity();
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< world, of the fine mesh
  std::int32_t triangle = -1;  ///< one that has the point, numbered as in CageHierarchy::fine; -1 if none is found
  SurfaceFeature feature = SurfaceFeature::face;
  std::int32_t corner = 0;  ///< 0 to 2; 0 of a face

  bool found() const { return triangle >= 0; }
};

struct ClosestPointOptions {
  /// World units, > 0, usually infinite. The query looks for points nearer than this. Small limits make it fast.
  double limit = std::numeric_limits<double>::infinity();
};

/// Finds the point of a body's surface that is nearest to a point. Interiors do not matter: the distance is that to the
/// surface from either side. Of several equally near triangles the first in the mesh is named. Without a fine mesh
/// nothing is found, and `lower` is a bound from the finest cages: 0 inside one. `lower` is 0 if the start pose is not
/// usable, the point is not finite or the limit is not positive.
ClosestPoint closest_point(const Shape& shape, const Motion& motion, const Eigen::Vector3d& point,
                           const ClosestPointOptions& options = {}) noexcept;

/// closest_point() for many points: results[i] answers points[i]. If the spans differ in length, the longer one's rest
/// is ignored.
void closest_points(const Shape& shape, const Motion& motion, std::span<const Eigen::Vector3d> points,
                    std::span<ClosestPoint> results, const ClosestPointOptions& options = {}) noexcept;

/// A distance that is negative inside the solid.
struct SignedDistance {
  /// World units: lower <= signed distance <= upper. Where `side` is unknown, lower = -upper. Both are infinite if no
  /// point of the surface is below the limit, except on the side that is known: then one is the limit, less rounding.
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  PointSide side = PointSide::unknown;
  ClosestPoint closest;  ///< the unsigned answer
};

/// Computes the distance from a point to a body's surface, with the sign of contains(): negative inside. The sign comes
/// from winding numbers, not from normals, so that it is right beside sharp edges, in cavities, and in parts that
/// overlap. An open surface (Solid::surface_only) has an unknown side, and a hollow body no inside. For a compound it
/// is the least of the signed distances of its parts: where parts overlap, the union is deeper than that.
SignedDistance signed_distance(const Shape& shape, const Motion& motion, const Eigen::Vector3d& point,
                               const ClosestPointOptions& options = {}) noexcept;

/// signed_distance() for many points: results[i] answers points[i]. If the spans differ in length, the longer one's
/// rest is ignored.
void signed_distances(const Shape& shape, const Motion& motion, std::span<const Eigen::Vector3d> points,
                      std::span<SignedDistance> results, const ClosestPointOptions& options = {}) noexcept;

// ---- Volumes -------------------------------------------------------------------

struct Sphere {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< world
  double radius = 0;                                 ///< world units, >= 0
};

/// All points within the radius of the segment between `a` and `b`.
struct Capsule {
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = Eigen::Vector3d::Zero();  ///< world
  double radius = 0;                                                         ///< world units, >= 0
};

/// The points pose * x with |x_k| <= half_k.
struct OrientedBox {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< within 1e-9 of rigid
  Eigen::Vector3d half = Eigen::Vector3d::Zero();          ///< world units, >= 0
};

/// True unless it is proven that a body, as it was baked, and a volume have no point in common. Solids are solid: a
/// sphere inside a closed mesh overlaps it. "True" is not proven: volumes within the rounding of the body (with S
/// including the volume) and its CageHierarchy::fine_error may overlap, and so may whatever lies in the box of a body
/// whose interior is unknown. Without a fine mesh the finest cages stand for the body. The answer is true if the start
/// pose is not usable, a number is not finite, or a radius or a half size is negative.
bool overlaps(const Shape& shape, const Motion& motion, const Sphere& sphere) noexcept;
bool overlaps(const Shape& shape, const Motion& motion, const Capsule& capsule) noexcept;
bool overlaps(const Shape& shape, const Motion& motion, const OrientedBox& box) noexcept;
bool overlaps(const Shape& shape, const Motion& motion, const HalfSpace& half_space) noexcept;

/// The same for the convex hull of some points in the world, widened by `radius` >= 0. The points may be coplanar,
/// collinear or equal. No points have no hull, which overlaps nothing. Tests of triangles take time proportional to
/// the number of points.
bool overlaps(const Shape& shape, const Motion& motion, std::span<const Eigen::Vector3d> hull,
              double radius = 0) noexcept;

}  // namespace encage
