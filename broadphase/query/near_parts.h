// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/query/posed_part.h"

#include <array>

namespace encage {

/// The tree of a compound's parts at the start of a motion, asked in the compound's own frame.
class PosedParts {
 public:
  PosedParts(const CompoundShape& compound, const Motion& motion) noexcept
      : compound_(compound), motion_(motion), to_local_(motion.start.linear().inverse()) {
    size_ = size_in_world(compound, motion);
  }

  Eigen::Vector3d local(const Eigen::Vector3d& world) const {
    return to_local_ * (world - motion_.start.translation()) / motion_.scale;
  }
  Eigen::Vector3d local_direction(const Eigen::Vector3d& world) const { return to_local_ * world / motion_.scale; }
  /// Local units. Bounds the errors of local(), as PosedPart::rounding() does.
  double rounding(double norm) const { return 96 * eps * (norm + size_) / motion_.scale; }
  double scale() const { return motion_.scale; }
  /// Returns what a length of the compound's frame is in the world at least.
  double shortest(double local) const { return (1 - rigid_tolerance - 8 * eps) * motion_.scale * local; }

  /// Calls visit(const MovingPart&) -> bool for the parts whose boxes may_meet(box) does not leave out, in a fixed
  /// order, until it returns false; returns false if it did.
  template <class MayMeet, class Visit>
  bool visit(MayMeet&& may_meet, Visit&& visit_part) const {
    return visit_in_order(may_meet, visit_part, [](const auto&, const auto&) { return false; });
  }
  /// The same; of two nodes, the second one comes first if swap(first box, second box).
  template <class MayMeet, class Visit, class Swap>
  bool visit_in_order(MayMeet&& may_meet, Visit&& visit_part, Swap&& swap) const {
    std::array<std::int32_t, 66> stack;  // the tree is balanced
    std::size_t size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const PartNode& node = compound_.nodes[static_cast<std::size_t>(stack[--size])];
      if (!may_meet(node.box)) continue;
      if (node.part >= 0) {
        if (!visit_part(moving_part(compound_, static_cast<std::size_t>(node.part), motion_))) return false;
      } else {
        const auto [first, second] = node.children;
        const bool swapped = swap(box_of(first), box_of(second));
        stack[size++] = swapped ? first : second;
        stack[size++] = swapped ? second : first;
      }
    }
    return true;
  }

 private:
  const Eigen::AlignedBox3d& box_of(std::int32_t node) const {
    return compound_.nodes[static_cast<std::size_t>(node)].box;
  }

  const CompoundShape& compound_;
  const Motion& motion_;
  Eigen::Matrix3d to_local_;
  double size_ = 0;
};

inline Motion start_of(const Motion& motion) { return Motion::resting(motion.start, motion.scale); }

/// Returns the fine mesh, kept in memory by the lease; null if there is none, or none that can be read.
inline const Surface* fine_surface(const SimpleShape& shape, FineLease& lease) noexcept {
  return shape.has_fine() && lease.take(shape) ? &shape.fine : nullptr;
}

}  // namespace encage
