// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"

#include <array>

namespace encage {

/// Tests a moving surface against a half-space. Heights of vertices above the plane are linear in time.
class PlaneCheck {
 public:
  /// Tests shape.outer(). `margin` counts throughout the motion, `arc` as arc * 4 t (1 - t). The motion must be usable.
  /// A normal whose length is not 1 within rigid_tolerance proves nothing.
  PlaneCheck(const SimpleShape& shape, const Motion& motion, const HalfSpace& plane, double margin,
             double arc = 0) noexcept
      : PlaneCheck(shape, shape.outer(), motion, plane, margin, arc) {}
  /// Tests the given surface of the shape.
  PlaneCheck(const SimpleShape& shape, const Surface& surface, const Motion& motion, const HalfSpace& plane,
             double margin, double arc = 0) noexcept;

  /// True only if every vertex stays above the plane by more than margin and arc, rounding included.
  bool beyond_throughout() const noexcept;

  /// Calls visit(vertex, time) for every vertex that is not proven to stay above, with a lower bound of the first time.
  /// A vertex may be visited several times.
  template <class Visit>
  void visit_reaching(Visit&& visit) const {
    struct Context {
      const PlaneCheck& check;
      Visit& visit;
    } context{*this, visit};
    visit_near(
        [](void* c, std::int32_t vertex) {
          const auto& [check, call] = *static_cast<Context*>(c);
          const double time = check.first_time(vertex);
          if (time <= 1) call(vertex, time);
        },
        &context);
  }

 private:
  void visit_near(void (*visit)(void* context, std::int32_t vertex), void* context) const;
  double first_time(std::int32_t vertex) const;  ///< 2 if it is proven that there is none

  const ScaledSurface surface_;
  std::array<Eigen::Vector3d, 2> normal_;  ///< of the plane, in the local frame at both ends
  std::array<double, 2> height_;           ///< of the local origin above the plane, at both ends
  double clearance_;                       ///< height that proves absence of contact, rounding included
  double arc_;
};

}  // namespace encage
