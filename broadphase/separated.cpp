// SPDX-License-Identifier: Apache-2.0
#include "broadphase/containment.h"
#include "broadphase/frame.h"
#include "broadphase/surface_pair.h"

#include <algorithm>

namespace encage {
namespace {

bool body_boxes_apart(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin) {
  const auto ball = [](const Shape& shape, const Motion& motion) {
    return ball_box(shape, motion.start).merged(ball_box(shape, motion.end));
  };
  return boxes_apart(ball(a, motion_a), ball(b, motion_b), margin) ||
         boxes_apart(world_box(a, motion_a), world_box(b, motion_b), margin);
}

/// Two bodies at rest: what the stages after the boxes share.
class RestingPair {
 public:
  RestingPair(const Shape& a, const Eigen::Isometry3d& pose_a, const Shape& b, const Eigen::Isometry3d& pose_b,
              double margin)
      : a_(a),
        b_(b),
        b_to_a_(relative_frame(a, pose_a, b, pose_b)),
        a_to_b_(relative_frame(b, pose_b, a, pose_a)),
        distance_(required_distance(a, pose_a, b, pose_b, margin)) {}

  bool cages_apart(const Surface& cage_a, const Surface& cage_b) const {
    return !hold(a_.solid == Solid::surface_only, b_.solid == Solid::surface_only) &&
           surfaces_apart(cage_a, cage_b, b_to_a_, distance_) && all_outside(cage_b, cage_a, a_to_b_) &&
           all_outside(cage_a, cage_b, b_to_a_);
  }

  bool fine_apart() const {
    const bool open_a = a_.solid == Solid::surface_only || !a_.fine.closed;
    const bool open_b = b_.solid == Solid::surface_only || !b_.fine.closed;
    // A pose stretches lengths by less than 1e-9.
    const double distance = distance_ + (1 + 1e-8) * (a_.fine_error + b_.fine_error);
    return !hold(open_a, open_b) && surfaces_apart(a_.fine, b_.fine, b_to_a_, distance) &&
           (open_b || all_outside(b_.fine, a_.fine, a_to_b_)) && (open_a || all_outside(a_.fine, b_.fine, b_to_a_));
  }

 private:
  // Whether one may lie in the other's unknown interior.
  bool hold(bool open_a, bool open_b) const {
    return (open_a && could_hold(a_, b_, b_to_a_, distance_)) || (open_b && could_hold(b_, a_, a_to_b_, distance_));
  }

  const Shape& a_;
  const Shape& b_;
  PairFrame b_to_a_, a_to_b_;
  double distance_;
};

}  // namespace

Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  double margin) noexcept {
  const bool usable = is_usable(motion_a.start) && is_usable(motion_a.end) && is_usable(motion_b.start) &&
                      is_usable(motion_b.end) && margin >= 0;
  if (!usable) return {};
  if (body_boxes_apart(a, motion_a, b, motion_b, margin)) return {true, Stage::box, -1};
  if (!motion_a.at_rest() || !motion_b.at_rest()) return {};

  const RestingPair pair(a, motion_a.start, b, motion_b.start, margin);
  Verdict last;
  if (!a.cages.empty() && !b.cages.empty()) {
    const int count_a = level_count(a), count_b = level_count(b);
    for (int k = std::max(count_a, count_b) - 1; k >= 0; --k) {
      last = {false, Stage::cage, static_cast<std::int16_t>(k)};
      if (pair.cages_apart(a.cages[std::min(k, count_a - 1)], b.cages[std::min(k, count_b - 1)])) {
        return {true, Stage::cage, static_cast<std::int16_t>(k)};
      }
    }
  }
  if (a.fine.empty() || b.fine.empty()) return last;
  return {pair.fine_apart(), Stage::fine, -1};
}

}  // namespace encage
