// SPDX-License-Identifier: Apache-2.0
#include "broadphase/containment.h"
#include "broadphase/frame.h"
#include "broadphase/plane_check.h"
#include "broadphase/surface_pair.h"

#include <algorithm>
#include <cmath>

namespace encage {
namespace {

bool body_boxes_apart(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin) {
  const auto ball = [](const Shape& shape, const Motion& motion) {
    return ball_box(shape, {motion.start, motion.scale}).merged(ball_box(shape, {motion.end, motion.scale}));
  };
  return boxes_apart(ball(a, motion_a), ball(b, motion_b), margin) ||
         boxes_apart(world_box(a, motion_a), world_box(b, motion_b), margin);
}

/// Covers the error of the stored fine meshes; a pose stretches it by less than 1e-9.
double fine_slack(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b) {
  return (1 + 1e-8) * (motion_a.scale * a.fine_error + motion_b.scale * b.fine_error);
}

/// What the stages after the boxes share. Closed surfaces that never meet keep their places inside
/// and outside of each other: that is asked at the start of the step only.
class BodyPair {
 public:
  BodyPair(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin)
      : a_(a),
        b_(b),
        scale_a_(motion_a.scale),
        scale_b_(motion_b.scale),
        motion_(pair_motion(a, motion_a, b, motion_b)),
        b_to_a_(relative_frame(a, {motion_a.start, scale_a_}, b, {motion_b.start, scale_b_})),
        a_to_b_(relative_frame(b, {motion_b.start, scale_b_}, a, {motion_a.start, scale_a_})),
        distance_(required_distance(a, motion_a, b, motion_b, margin)),
        fine_distance_(distance_ + fine_slack(a, motion_a, b, motion_b)) {}

  bool cages_apart(const Surface& of_a, const Surface& of_b) const {
    const ScaledSurface cage_a(of_a, scale_a_), cage_b(of_b, scale_b_);
    return !hold(a_.solid == Solid::surface_only, b_.solid == Solid::surface_only) &&
           surfaces_apart(cage_a, cage_b, motion_, distance_) && all_outside(cage_b, cage_a, a_to_b_) &&
           all_outside(cage_a, cage_b, b_to_a_);
  }

  bool fine_apart() const {
    const bool open_a = a_.solid == Solid::surface_only || !a_.fine.closed;
    const bool open_b = b_.solid == Solid::surface_only || !b_.fine.closed;
    const ScaledSurface fine_a(a_.fine, scale_a_), fine_b(b_.fine, scale_b_);
    return !hold(open_a, open_b) && surfaces_apart(fine_a, fine_b, motion_, fine_distance_) &&
           (open_b || all_outside(fine_b, fine_a, a_to_b_)) && (open_a || all_outside(fine_a, fine_b, b_to_a_));
  }

 private:
  // Whether one may lie in the other's unknown interior.
  bool hold(bool open_a, bool open_b) const {
    return (open_a && could_hold(a_, scale_a_, motion_.a, b_, scale_b_, motion_.b, distance_)) ||
           (open_b && could_hold(b_, scale_b_, motion_.b, a_, scale_a_, motion_.a, distance_));
  }

  const Shape& a_;
  const Shape& b_;
  double scale_a_, scale_b_;
  PairMotion motion_;
  PairFrame b_to_a_, a_to_b_;
  double distance_, fine_distance_;
};

}  // namespace

Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  const PairOptions& options) noexcept {
  if (!is_usable(motion_a) || !is_usable(motion_b) || !(options.margin >= 0)) return {};
  if (options.boxes && body_boxes_apart(a, motion_a, b, motion_b, options.margin)) return {true, Stage::box, -1};

  const BodyPair pair(a, motion_a, b, motion_b, options.margin);
  Verdict last;
  const bool fine = options.fine && !a.fine.empty() && !b.fine.empty();
  const bool cages = options.cages == CageUse::always || (options.cages == CageUse::automatic && !fine);
  if (cages && !a.cages.empty() && !b.cages.empty()) {
    const int count_a = level_count(a), count_b = level_count(b);
    const int coarsest = std::min(options.coarsest_cage, std::max(count_a, count_b) - 1);
    for (int k = coarsest; k >= std::max(options.finest_cage, 0); --k) {
      last = {false, Stage::cage, static_cast<std::int16_t>(k)};
      if (pair.cages_apart(a.cages[std::min(k, count_a - 1)], b.cages[std::min(k, count_b - 1)])) {
        return {true, Stage::cage, static_cast<std::int16_t>(k)};
      }
    }
  }
  if (!fine) return last;
  return {pair.fine_apart(), Stage::fine, -1};
}

Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  double margin) noexcept {
  return separated(a, motion_a, b, motion_b, PairOptions{.margin = margin});
}

Verdict separated(const Shape& a, const Motion& motion_a, const HalfSpace& plane, double margin) noexcept {
  if (!is_usable(motion_a) || !(margin >= 0)) return {};
  const Stage stage = a.fine.empty() ? Stage::cage : Stage::fine;
  return {PlaneCheck(a, motion_a, plane, margin).beyond_throughout(), stage,
          static_cast<std::int16_t>(a.fine.empty() ? 0 : -1)};
}

bool visit_candidates(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin,
                      bool (*visit)(void* context, TrianglePair pair), void* context) {
  if (a.fine.empty() || b.fine.empty()) return true;
  if (!is_usable(motion_a) || !is_usable(motion_b) || !(margin >= 0)) {
    const auto count_a = static_cast<std::int32_t>(a.fine.mesh.triangles.size());
    const auto count_b = static_cast<std::int32_t>(b.fine.mesh.triangles.size());
    for (std::int32_t i = 0; i < count_a; ++i) {
      for (std::int32_t j = 0; j < count_b; ++j) {
        if (!visit(context, {i, j})) return false;
      }
    }
    return true;
  }
  struct Context {
    bool (*visit)(void* context, TrianglePair pair);
    void* context;
  } inner{visit, context};
  return visit_near_triangles(
      {a.fine, motion_a.scale}, {b.fine, motion_b.scale}, pair_motion(a, motion_a, b, motion_b),
      required_distance(a, motion_a, b, motion_b, margin) + fine_slack(a, motion_a, b, motion_b), Effort::full,
      [](void* c, std::int32_t i, std::int32_t j) {
        const auto& [call, outer] = *static_cast<const Context*>(c);
        return call(outer, {i, j});
      },
      &inner);
}

double arc_margin(const Shape& shape, const Motion& motion, const Eigen::Vector3d& pivot) noexcept {
  if (motion.start.linear() == motion.end.linear()) return 0;
  // The Frobenius norm of R1 - R0 is sqrt(8) sin(angle/2).
  const double departure = departure_from_rigid(motion.start.linear()) + departure_from_rigid(motion.end.linear());
  const double norm = (motion.end.linear() - motion.start.linear()).norm() + 2 * departure;
  const double sine = std::min(1.0, norm / std::sqrt(8.0) * (1 + 1e-12));
  const double cosine = std::sqrt((1 - sine) * (1 + sine));
  // 1 - cos = sin^2 / (1 + cos): without cancellation.
  const double radius = motion.scale * (shape.outer().radius + (shape.origin - pivot).norm() + shape.outer_error());
  return radius * (sine * sine / (1 + cosine)) * (1 + 1e-8);
}

}  // namespace encage
