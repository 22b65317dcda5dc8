// SPDX-License-Identifier: Apache-2.0
#pragma once

// Queries of all bodies and half-spaces of a World: rays, nearest points, points in solids, and overlap with volumes.

#include <encage/export.h>
#include <encage/queries.h>
#include <encage/world.h>

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <variant>

// Every query answers what the query of <encage/queries.h> of the same name answers about each body, with its Motion in
// the world, unless its world_box() proves more: bodies are where their motions start, after corrections
// (World::motion()). Margins, deformations, sleep and groups do not count: where surfaces may be off by
// World::deformation() or a corrected pose, widen the question. A half-space is a solid, its surface the plane. Its
// rounding is at most 1e-13 (|offset| + norm of the point or origin).
//
// Queries only read: any number of threads may ask a world at a time, as long as none changes it or searches it for
// pairs. They allocate nothing, except that a ShapeCache may have to read a mesh. The same world gives the same bits on
// every instruction set. Bodies that have changed since the last search or World::update_boxes() are asked one after
// the other: call that before many queries. Bad input gives the answers that <encage/queries.h> names. What `accept`
// and the visitors throw is passed on; they may ask the world, but not change it.
namespace ENCAGE_EXPORT encage {

/// A body or a half-space. They are ordered: bodies by increasing index, then half-spaces by increasing index.
struct WorldObject {
  BodyId body = BodyId::none;
  HalfSpaceId half_space = HalfSpaceId::none;

  bool exists() const { return body != BodyId::none || half_space != HalfSpaceId::none; }
  friend bool operator==(const WorldObject&, const WorldObject&) = default;
};

/// Which objects a query asks. By default all.
struct WorldQueryOptions {
  /// If set, only objects whose filters allow a pair with this one.
  std::optional<Filter> filter{};
  bool sensors = true;      ///< false: no bodies with BodyOptions::sensor
  bool half_spaces = true;  ///< false: bodies only
  /// If set, it is called with every object that the query may find, before its shape is asked, in an order that
  /// depends on the world's past. If it returns false, the object is left out.
  std::function<bool(const WorldObject&)> accept{};
};

// ---- Rays ----------------------------------------------------------------------

/// What a ray meets.
struct WorldRayHit {
  /// Unknown for an object of which nothing is proven, e.g. a body without a fine mesh: only `hit.t` is set, and no hit
  /// of the object is earlier.
  RayAnswer answer = RayAnswer::miss;
  WorldObject object{};
  RayHit hit;  ///< of a half-space: without a triangle
};

/// Finds the first object that a ray meets. Of several hits with the same t, one that is unknown counts, then the first
/// object. The answer is unknown, without object and with t = t_min, for a ray that is none.
WorldRayHit cast_ray(const World& world, const Ray& ray, const RayOptions& ray_options = {},
                     const WorldQueryOptions& options = {});

/// cast_ray() for many rays: results[i] answers rays[i]. If the spans differ in length, the longer one's rest is
/// ignored.
void cast_rays(const World& world, std::span<const Ray> rays, std::span<WorldRayHit> results,
               const RayOptions& ray_options = {}, const WorldQueryOptions& options = {});

/// Finds all triangles and planes that a ray meets, and objects that it may meet, by increasing t, object and triangle.
/// If there are more than `hits` has room for, it gets the first ones; RayHits::count counts all. The answer is unknown
/// if that of an object is. Takes time proportional to hits.size() for each hit beyond.
RayHits all_hits(const World& world, const Ray& ray, std::span<WorldRayHit> hits, const RayOptions& ray_options = {},
                 const WorldQueryOptions& options = {});

/// Calls visit(context, hit) for the same hits, object by object in their order and within a body in a fixed order that
/// is not that of t, until it returns false. Of a body that is unknown an unknown hit comes last.
RayAnswer visit_hits(const World& world, const Ray& ray, const RayOptions& ray_options,
                     const WorldQueryOptions& options, bool (*visit)(void* context, const WorldRayHit& hit),
                     void* context);
/// visit_hits() with visit(const WorldRayHit&) -> bool.
template <class Visit>
RayAnswer for_each_hit(const World& world, const Ray& ray, const RayOptions& ray_options,
                       const WorldQueryOptions& options, Visit&& visit) {
  return visit_hits(
      world, ray, ray_options, options,
      [](void* context, const WorldRayHit& hit) {
        return (*static_cast<std::remove_reference_t<Visit>*>(context))(hit);
      },
      const_cast<void*>(static_cast<const void*>(&visit)));
}

// ---- Points --------------------------------------------------------------------

struct WorldClosestPoint {
  WorldObject object{};  ///< none if nothing is found
  /// As of one body, with bounds of the distance to the nearest surface of all objects: a body without a fine mesh only
  /// makes `lower` less. Of a half-space: without a triangle, so that ClosestPoint::found() is false.
  ClosestPoint closest;

  bool found() const { return object.exists(); }
};

/// Finds the surface that is nearest to a point, and its point there. Of several whose upper bounds are equal, the
/// first object counts.
WorldClosestPoint closest_point(const World& world, const Eigen::Vector3d& point,
                                const ClosestPointOptions& point_options = {}, const WorldQueryOptions& options = {});

/// Calls visit(context, object, side) for every object whose solid contains the point, or may contain it
/// (PointSide::unknown), in their order, until it returns false. The answer is `inside` if the point was inside an
/// object visited, else unknown if one was unknown or if the point is none, else outside: proven, of all.
PointSide visit_objects_at(const World& world, const Eigen::Vector3d& point, const WorldQueryOptions& options,
                           bool (*visit)(void* context, const WorldObject& object, PointSide side), void* context);
/// visit_objects_at() with visit(const WorldObject&, PointSide) -> bool.
template <class Visit>
PointSide for_each_object_at(const World& world, const Eigen::Vector3d& point, const WorldQueryOptions& options,
                             Visit&& visit) {
  return visit_objects_at(
      world, point, options,
      [](void* context, const WorldObject& object, PointSide side) {
        return (*static_cast<std::remove_reference_t<Visit>*>(context))(object, side);
      },
      const_cast<void*>(static_cast<const void*>(&visit)));
}

// ---- Volumes -------------------------------------------------------------------

/// The convex hull of points in the world, widened by a radius.
struct Hull {
  std::span<const Eigen::Vector3d> points{};  ///< coplanar, collinear and equal ones included; must outlive the call
  double radius = 0;                          ///< world units, >= 0
};

using Volume = std::variant<Sphere, Capsule, OrientedBox, HalfSpace, Hull>;

/// Calls visit(context, object) for every object that is not proven to have no point in common with the volume, in
/// their order, until it returns false; returns false if it did. A volume that is none (overlaps()) may overlap all
/// objects, a hull of no points none.
bool visit_overlaps(const World& world, const Volume& volume, const WorldQueryOptions& options,
                    bool (*visit)(void* context, const WorldObject& object), void* context);
/// visit_overlaps() with visit(const WorldObject&) -> bool.
template <class Visit>
bool for_each_overlap(const World& world, const Volume& volume, const WorldQueryOptions& options, Visit&& visit) {
  return visit_overlaps(
      world, volume, options,
      [](void* context, const WorldObject& object) {
        return (*static_cast<std::remove_reference_t<Visit>*>(context))(object);
      },
      const_cast<void*>(static_cast<const void*>(&visit)));
}

/// True unless it is proven that no object has a point in common with the volume.
bool overlaps(const World& world, const Volume& volume, const WorldQueryOptions& options = {});

}  // namespace encage
