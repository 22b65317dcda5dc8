// SPDX-License-Identifier: Apache-2.0
#pragma once

// Certified rejection of pairs of bodies, and the candidate triangles of the remaining pairs.

#include <encage/export.h>
#include <encage/shape.h>

#include <cstdint>
#include <limits>
#include <type_traits>

namespace ENCAGE_EXPORT encage {

/// The stage that gave a verdict, or the last one that was tested.
enum class Stage : std::uint8_t {
  box,   ///< axis-aligned world boxes of the bodies
  cage,  ///< a pair of cages
  fine,  ///< the fine meshes
};

struct Verdict {
  bool separated = false;  ///< proven farther apart than the margin, rounding included
  Stage stage = Stage::box;
  std::int16_t level = -1;  ///< for Stage::cage: index of the cage level, 0 the finest
  /// False if nothing was tested, because a motion (is_usable(), motion_defect()) or the margin is not usable: the
  /// answer stays "maybe" until the caller mends it, e.g. by nearest_rigid().
  bool usable = true;
  /// "Maybe", because the query reached the end of its budget of work (PairOptions::most_steps): very many triangles
  /// stay very near each other.
  bool exhausted = false;
};

/// Decides when cages are tested.
enum class CageUse : std::uint8_t {
  /// Tests cages only where the fine meshes are not tested, and before a fine mesh of a ShapeCache, which may have to
  /// be read first. A fine mesh's own tree proves more than a cage, in less time (docs/performance.md), so that cages
  /// pay only in front of something slower, e.g. an engine's own test.
  automatic,
  always,
  never,
};

/// Which stages separated() tests, and with which margin.
struct PairOptions {
  double margin = 0;  ///< world units, >= 0, usually 0
  bool boxes = true;  ///< tests the world boxes; false where the caller has tested them
  CageUse cages = CageUse::automatic;
  int finest_cage = 0;                                  ///< finest cage level tested; 0 is the finest of all
  int coarsest_cage = std::numeric_limits<int>::max();  ///< the coarsest level tested
  bool fine = true;                                     ///< tests the fine meshes
  /// Budget of work for each pair of simple shapes: a step is about the test of a box against eight, some 50 to 100 ns.
  /// The number of steps that a query takes depends on its arguments alone.
  std::int64_t most_steps = 1 << 20;
};

/// Proves that two bodies stay farther apart than the margin while every vertex moves on its straight line, or answers
/// "maybe". The stages follow each other in this order: boxes, cages from coarse to fine (by default only where no fine
/// mesh is tested), fine meshes; the first proof ends the test. If the numbers of levels differ, level k stands for
/// each body's level k or its coarsest, and a primitive is its own level. The answer is "maybe" for motions that are
/// not usable (Verdict::usable). Re-entrant; never throws, never allocates, except that a ShapeCache may have to read a
/// fine mesh.
///
/// Bodies turn the short way between their poses, and two poses do not tell more (Motion). For true rotation add both
/// bodies' arc_margin() to the margin.
///
/// A closed or capped body is its surface and the points of non-zero winding number. A `surface_only` body is its
/// surface; as its interior is unknown, the answer is "maybe" if a connected part of the other body lies wholly in its
/// convex hull. A hollow body is its surface. docs/guarantee.md proves each stage.
Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  const PairOptions& options) noexcept;
Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  double margin = 0) noexcept;

/// The same against a half-space: every vertex of the body stays beyond the plane by more than the margin.
Verdict separated(const Shape& a, const Motion& motion_a, const HalfSpace& plane, double margin = 0) noexcept;

/// Triangles of two fine meshes, numbered as in CageHierarchy::fine.
struct TrianglePair {
  std::int32_t a = 0;
  std::int32_t b = 0;
};

/// Calls visit(TrianglePair) -> bool for every pair of fine triangles that is not proven farther apart than the margin
/// during the motion (see separated()), in a fixed order, until visit returns false. Returns false if visit did. There
/// is no budget of work: of bodies in the same place this may visit nearly all pairs that there are. Visits none if a
/// body has no fine mesh. Throws Error, before any call, for a motion or a margin that is not usable, of
/// which nothing is known (two meshes of half a million triangles have 2.5e11 pairs), and if the fine mesh of a shape
/// of a ShapeCache cannot be read. Re-entrant; allocates nothing, except to read such a mesh.
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

struct TrianglePairOptions {
  double margin = 0;  ///< world units, >= 0, usually 0
  /// >= 0. Budget of work for each pair of simple shapes, as in PairOptions; a pair that is visited takes 16 steps.
  std::int64_t most_steps = 1 << 20;
};

/// How the visits of triangle pairs ended.
enum class VisitEnd : std::uint8_t {
  complete,   ///< every pair that may be near was visited
  stopped,    ///< visit returned false
  exhausted,  ///< the budget of work ended: any pair that was not visited may be near, too
};

/// for_each_triangle_pair() with a budget of work. Which pairs are visited before it ends depends on the arguments
/// alone. Throws Error as above, and for a negative budget.
template <class Visit>
[[nodiscard]] VisitEnd for_each_triangle_pair(const Shape& a, const Motion& motion_a, const Shape& b,
                                              const Motion& motion_b, const TrianglePairOptions& options,
                                              Visit&& visit) {
  return visit_triangle_pairs(
      a, motion_a, b, motion_b, options,
      [](void* context, TrianglePair pair) { return (*static_cast<std::remove_reference_t<Visit>*>(context))(pair); },
      const_cast<void*>(static_cast<const void*>(&visit)));
}
[[nodiscard]] VisitEnd visit_triangle_pairs(const Shape& a, const Motion& motion_a, const Shape& b,
                                            const Motion& motion_b, const TrianglePairOptions& options,
                                            bool (*visit)(void* context, TrianglePair pair), void* context);

}  // namespace encage
