// SPDX-License-Identifier: Apache-2.0
#pragma once

// Certified rejection of pairs of bodies, and the triangles of those that are left.

#include <encage/export.h>
#include <encage/shape.h>

#include <cstdint>
#include <limits>
#include <type_traits>

namespace ENCAGE_EXPORT encage {

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

/// When cages are worth asking.
enum class CageUse : std::uint8_t {
  /// Where the fine meshes are not asked: a fine mesh's own tree proves more than a cage, in less time
  /// (docs/performance.md), so that cages pay only in front of something slower, e.g. an engine's own test. And in
  /// front of a fine mesh of a
  /// ShapeCache, which may have to be read first.
  automatic,
  always,
  never,
};

/// What separated() asks.
struct PairOptions {
  double margin = 0;  ///< world units, >= 0
  bool boxes = true;  ///< ask world boxes; false where the caller did
  CageUse cages = CageUse::automatic;
  int finest_cage = 0;                                  ///< the finest cage level asked
  int coarsest_cage = std::numeric_limits<int>::max();  ///< the coarsest one asked
  bool fine = true;                                     ///< ask the fine meshes
};

/// Proves that two bodies stay farther apart than the margin while every vertex
/// moves on its straight line, or answers "maybe". Asks the stages in order: boxes, cages from
/// coarse to fine (by default only where there is no fine mesh to ask), fine meshes; the first proof ends the test.
/// With different numbers of levels, level k is tested on each body's level k or its coarsest. Motions that are not
/// usable answer "maybe". Re-entrant; never throws, never allocates.
///
/// A closed or capped body is its surface and the points of non-zero winding
/// number. A `surface_only` body is its surface; as its interior is unknown,
/// another body of which a connected part lies wholly in its convex hull answers
/// "maybe". A hollow body is its surface. docs/guarantee.md proves each stage.
Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  const PairOptions& options) noexcept;
Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  double margin = 0) noexcept;

/// The same against a half-space: every vertex of the body stays beyond the plane by more than the margin.
Verdict separated(const Shape& a, const Motion& motion_a, const HalfSpace& plane, double margin = 0) noexcept;

/// Triangles of two fine meshes, as CageHierarchy::fine counts them.
struct TrianglePair {
  std::int32_t a = 0;
  std::int32_t b = 0;
};

/// Calls visit(TrianglePair) -> bool for every pair of fine triangles that is not proven
/// farther apart than the margin during the motion, in a fixed order, until visit returns false. Returns
/// false if it did. All pairs, if a motion is not usable. No call if a body has no fine mesh. Throws Error, before any
/// call, if the fine mesh of a shape of a ShapeCache cannot be read. Re-entrant; allocates nothing.
template <class Visit>
bool for_each_triangle_pair(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                            double margin, Visit&& visit) {
  return visit_triangle_pairs(
      a, motion_a, b, motion_b, margin,
      [](void* context, TrianglePair pair) { return (*static_cast<std::remove_reference_t<Visit>*>(context))(pair); },
      const_cast<void*>(static_cast<const void*>(&visit)));
}
/// for_each_triangle_pair() with a plain function; visit(context, pair).
bool visit_triangle_pairs(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin,
                          bool (*visit)(void* context, TrianglePair pair), void* context);

}  // namespace encage
