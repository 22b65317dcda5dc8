// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

#include <cstddef>

namespace encage {

/// One rigid part of a body as queries use it: a simple shape and its motion. A simple shape is its own only part.
struct ENCAGE_HIDDEN MovingPart {
  const SimpleShape* shape = nullptr;
  Motion motion;
  double slack = 0;                 ///< bounds how far the computed motion leads a point from its exact position
  std::int32_t first_triangle = 0;  ///< first triangle of the part's fine mesh, in the numbering of the whole body
  std::int32_t first_vertex = 0;
};

/// Returns part `index` of a compound that moves.
MovingPart moving_part(const CompoundShape& compound, std::size_t index, const Motion& motion) noexcept;

using VisitParts = bool (*)(void* context, const MovingPart& a, const MovingPart& b);

/// Calls visit for the pairs of parts whose boxes do not prove a distance of more than `margin`, until it returns
/// false; returns false if it did. One of the shapes, or both, are compounds; the motions are usable.
bool visit_parts(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin,
                 VisitParts visit, void* context);

/// visit_parts() with any function. For simple shapes it makes one call with the shapes themselves.
template <class Visit>
bool for_each_part_pair(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin,
                        Visit&& visit) {
  if (!a.is_compound() && !b.is_compound()) {
    return visit(MovingPart{&a.simple(), motion_a}, MovingPart{&b.simple(), motion_b});
  }
  return visit_parts(
      a, motion_a, b, motion_b, margin,
      [](void* context, const MovingPart& part_a, const MovingPart& part_b) {
        return (*static_cast<std::remove_reference_t<Visit>*>(context))(part_a, part_b);
      },
      const_cast<void*>(static_cast<const void*>(&visit)));
}

/// Calls visit(const MovingPart&) -> bool for every part until it returns false; returns false if it did.
template <class Visit>
bool for_each_part(const Shape& shape, const Motion& motion, Visit&& visit) {
  if (!shape.is_compound()) return visit(MovingPart{&shape.simple(), motion});
  const CompoundShape& compound = shape.compound();
  for (std::size_t i = 0; i < compound.parts.size(); ++i) {
    if (!visit(moving_part(compound, i, motion))) return false;
  }
  return true;
}

/// Returns a part near `box`, of the world: that of the nearer boxes down the tree, not always the nearest one.
MovingPart near_part(const Shape& shape, const Motion& motion, const Eigen::AlignedBox3d& box) noexcept;

/// Bounds the sum of the magnitudes from which positions of the body's points in the world are computed.
double size_in_world(const Shape& shape, const Motion& motion) noexcept;

/// Returns the index in CompoundShape::parts of the part that contains a triangle of the compound.
std::size_t part_of_triangle(const CompoundShape& compound, std::int32_t triangle) noexcept;

}  // namespace encage
