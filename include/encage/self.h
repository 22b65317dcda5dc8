// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a mesh meets itself, and how near it comes to itself.

#include <encage/export.h>
#include <encage/separated.h>
#include <encage/shape.h>

#include <Eigen/Core>

#include <cstdint>
#include <limits>
#include <type_traits>

// These queries are about the fine mesh as it is stored, at rest in the frame of its body; its vertices are no farther
// than fine_error() from the source's. Triangles *share* a vertex if both have its index: vertices that merely are in
// the same place are different ones, so weld a mesh whose triangles have vertices of their own before. The parts of a
// compound are asked one by one, and numbered through; that parts overlap is none of these queries' business.
namespace ENCAGE_EXPORT encage {

struct SelfOptions {
  /// >= 0. Budget of work: a step is about the test of a box against eight, some 50 to 100 ns. A closed mesh that is
  /// free of intersections takes some 50 steps a triangle.
  std::int64_t most_steps = std::int64_t{1} << 28;
};

/// Two triangles that are not proven to have no more in common than the vertices and edges that they share.
struct SelfIntersection {
  TrianglePair triangles;  ///< a < b, numbered as in CageHierarchy::fine
  int shared = 0;          ///< number of vertices that they share, 0 to 3
  /// They certainly have more in common: an edge of one passes through the inside of the other, or they are one
  /// triangle twice. False where triangles touch, overlap in a plane, are folded onto each other, or nearly so.
  bool proven = false;
};

/// Calls visit(SelfIntersection) -> bool, once for each of these pairs, in a fixed order, until visit returns false. No
/// pair is left out that meets beyond what it shares, in exact arithmetic; pairs within rounding of that (1e-14 of
/// their size) may be visited. Throws Error, before any call, for a shape or a part without a fine mesh and for a
/// negative budget, and if the fine mesh of a shape of a ShapeCache cannot be read. Re-entrant; allocates nothing,
/// except to read such a mesh.
template <class Visit>
[[nodiscard]] VisitEnd for_each_self_intersection(const Shape& shape, const SelfOptions& options, Visit&& visit) {
  return visit_self_intersections(
      shape, options,
      [](void* context, const SelfIntersection& found) {
        return (*static_cast<std::remove_reference_t<Visit>*>(context))(found);
      },
      const_cast<void*>(static_cast<const void*>(&visit)));
}
/// for_each_self_intersection() with a plain function; visit(context, found).
[[nodiscard]] VisitEnd visit_self_intersections(const Shape& shape, const SelfOptions& options,
                                                bool (*visit)(void* context, const SelfIntersection& found),
                                                void* context);

enum class SelfAnswer : std::uint8_t {
  free,      ///< proven: no two triangles have more in common than the vertices and edges that they share
  touching,  ///< not proven free, and no pair is proven to cross
  crossing,  ///< proven: some pair has more in common
  unknown,   ///< nothing is known: a part has no fine mesh, or the budget ended
};

struct SelfResult {
  SelfAnswer answer = SelfAnswer::unknown;
  /// A pair for `crossing`, the first one that is proven; for `touching` the first pair. Otherwise -1 and -1.
  SelfIntersection first = {{-1, -1}, 0, false};
};

/// Says whether a mesh meets itself. A negative budget is none. Re-entrant; never throws, never allocates, except that
/// a ShapeCache may have to read a fine mesh.
SelfResult self_intersects(const Shape& shape, const SelfOptions& options = {}) noexcept;

struct SelfDistanceOptions {
  /// Units of the body frame, > 0, usually infinite. The query does not look for larger distances. Small limits save
  /// time.
  double limit = std::numeric_limits<double>::infinity();
  /// >= 0. The bounds may differ by this fraction of the distance, which saves time.
  double tolerance = 0;
  std::int64_t most_steps = std::int64_t{1} << 28;  ///< as in SelfOptions
};

struct SelfDistance {
  /// Units of the body frame: lower <= distance <= upper, the distance being the least of two triangles that share no
  /// vertex. They differ by rounding (some 1e-14 of the triangles and their distance), by more only next to degenerate
  /// triangles. `upper` is infinite if the distance is not below the limit, and if the mesh has no such pair; `lower`
  /// is then the limit.
  double lower = 0;
  double upper = std::numeric_limits<double>::infinity();
  /// Body frame: points of the triangles that are at most `upper` apart, but for the rounding of coordinates.
  Eigen::Vector3d point_a = Eigen::Vector3d::Zero(), point_b = Eigen::Vector3d::Zero();
  /// The triangles that contain these points, a < b, numbered as in CageHierarchy::fine; -1 if there are none.
  TrianglePair triangles = {-1, -1};
  /// The first pair of triangles that share vertices and are not proven to have only these, and the edges between them,
  /// in common. Such a pair is at distance 0 in any case, so that it does not count above. -1 and -1 if there is none.
  TrianglePair neighbours = {-1, -1};
  bool neighbours_proven = false;  ///< that pair has more in common for certain
  /// The budget of work ended: `lower` is 0, `upper` holds, and there may be other neighbours.
  bool exhausted = false;
};

/// Computes the least distance between parts of a mesh that are not neighbours: how thin it is, or how near its limbs
/// come to each other. Of equally near pairs any one is named, the same for the same shape. Without a fine mesh, and
/// for a limit, a tolerance or a budget that is not allowed, the bounds are 0 and infinity. Takes the longer the
/// smaller the triangles are beside this distance. Re-entrant; never throws, never allocates, except that a ShapeCache
/// may have to read a fine mesh.
SelfDistance self_distance(const Shape& shape, const SelfDistanceOptions& options = {}) noexcept;

}  // namespace encage
