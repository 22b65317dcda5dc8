// SPDX-License-Identifier: Apache-2.0
#include "broadphase/motion/pose.h"
#include "broadphase/motion/turned_box.h"
#include "broadphase/separation/containment.h"
#include "broadphase/separation/plane_check.h"
#include "broadphase/separation/surface_pair.h"
#include "broadphase/shape/compound.h"
#include "broadphase/shape/world_box.h"
#include "src/files/number_text.h"

#include <encage/error.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>

namespace encage {
namespace {

bool body_boxes_apart(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin) {
  const auto ball = [](const Shape& shape, const Motion& motion) {
    return ball_box(shape, {motion.start, motion.scale}).merged(ball_box(shape, {motion.end, motion.scale}));
  };
  return boxes_apart(ball(a, motion_a), ball(b, motion_b), margin) ||
         boxes_apart(world_box(a, motion_a), world_box(b, motion_b), margin);
}

/// The data that the stages after the boxes share. Closed surfaces that never meet cannot enter or leave each other:
/// containment is tested at the start of the step only.
class PartPair {
 public:
  PartPair(const SimpleShape& a, const Motion& motion_a, const SimpleShape& b, const Motion& motion_b, double margin,
           std::int64_t steps)
      : a_(a),
        b_(b),
        scale_a_(motion_a.scale),
        scale_b_(motion_b.scale),
        motion_(pair_motion(a.frame, motion_a, b.frame, motion_b)),
        b_to_a_(relative_frame(a.frame, {motion_a.start, scale_a_}, b.frame, {motion_b.start, scale_b_})),
        a_to_b_(relative_frame(b.frame, {motion_b.start, scale_b_}, a.frame, {motion_a.start, scale_a_})),
        distance_(required_distance(a.frame, motion_a, b.frame, motion_b, margin)),
        fine_distance_(distance_ + a.error_in_world(scale_a_) + b.error_in_world(scale_b_)),
        steps_(steps) {}

  // Containment in an unknown interior is tested last, since it may need a fine mesh.
  bool cages_apart(int level) {
    const ScaledSurface cage_a(*a_.level(level), scale_a_), cage_b(*b_.level(level), scale_b_);
    const double distance = distance_ + a_.beyond_level(scale_a_) + b_.beyond_level(scale_b_);
    return surfaces_apart(cage_a, cage_b, motion_, distance, &steps_) &&
           (flat_core(b_) || all_outside(cage_b, cage_a, a_to_b_)) &&
           (flat_core(a_) || all_outside(cage_a, cage_b, b_to_a_)) && !hold(unknown_in_cage(a_), unknown_in_cage(b_));
  }

  bool exhausted() const { return steps_ < 0; }

  bool fine_apart() {
    if (!take_fine()) return false;
    const Interior in_a = interior(a_), in_b = interior(b_);
    const ScaledSurface fine_a(a_.fine, scale_a_), fine_b(b_.fine, scale_b_);
    return !hold(in_a == Interior::unknown, in_b == Interior::unknown) &&
           surfaces_apart(fine_a, fine_b, motion_, fine_distance_, &steps_) &&
           (in_b != Interior::enclosed || all_outside(fine_b, fine_a, a_to_b_)) &&
           (in_a != Interior::enclosed || all_outside(fine_a, fine_b, b_to_a_));
  }

 private:
  // True if one body may lie in the other's unknown interior.
  bool hold(bool open_a, bool open_b) {
    if (!open_a && !open_b) return false;
    return !take_fine() || (open_a && could_hold(a_, scale_a_, motion_.a, b_, scale_b_, motion_.b, distance_)) ||
           (open_b && could_hold(b_, scale_b_, motion_.b, a_, scale_a_, motion_.a, distance_));
  }

  bool take_fine() { return lease_a_.take(a_) && lease_b_.take(b_); }

  const SimpleShape& a_;
  const SimpleShape& b_;
  FineLease lease_a_, lease_b_;
  double scale_a_, scale_b_;
  PairMotion motion_;
  AffineMap b_to_a_, a_to_b_;
  double distance_, fine_distance_;
  std::int64_t steps_;
};

/// Runs the stages after the boxes for simple shapes.
Verdict simple_separated(const SimpleShape& a, const Motion& motion_a, const SimpleShape& b, const Motion& motion_b,
                         const PairOptions& options) {
  PartPair pair(a, motion_a, b, motion_b, options.margin, options.most_steps);
  Verdict last;
  const bool fine = options.fine && a.has_fine() && b.has_fine();
  const bool cages = options.cages == CageUse::always ||
                     (options.cages == CageUse::automatic && (!fine || a.on_demand || b.on_demand));
  if (cages && a.level(0) != nullptr && b.level(0) != nullptr) {
    const int coarsest = std::min(options.coarsest_cage, std::max(level_count(a), level_count(b)) - 1);
    for (int k = coarsest; k >= std::max(options.finest_cage, 0); --k) {
      if (pair.cages_apart(k)) {
        return {true, Stage::cage, static_cast<std::int16_t>(k)};
      }
      last = {.stage = Stage::cage, .level = static_cast<std::int16_t>(k), .exhausted = pair.exhausted()};
    }
  }
  if (!fine) return last;
  const bool apart = pair.fine_apart();
  return {.separated = apart, .stage = Stage::fine, .exhausted = !apart && pair.exhausted()};
}

Verdict simple_separated(const MovingPart& a, const HalfSpace& plane, double margin) {
  const SimpleShape& shape = *a.shape;
  const bool beyond = PlaneCheck(shape, a.motion, plane, margin + a.slack).beyond_throughout();
  if (!shape.has_fine() || (shape.on_demand && beyond)) return {beyond, Stage::cage, 0};
  if (!shape.on_demand) return {beyond, Stage::fine, -1};
  FineLease lease;
  return {lease.take(shape) && PlaneCheck(shape, shape.fine, a.motion, plane, margin + a.slack).beyond_throughout(),
          Stage::fine, -1};
}

/// Combines the verdicts of all parts: the first that is not separated, or the last stage that some part needed.
class PartsVerdict {
 public:
  bool add(const Verdict& verdict) {
    if (!verdict.separated || verdict.stage >= all_.stage) all_ = verdict;
    return verdict.separated;
  }
  const Verdict& all() const { return all_; }

 private:
  Verdict all_{true, Stage::box, -1};
};

/// visit_triangle_pairs() for two parts.
struct PartTrianglePairs {
  const MovingPart& a;
  const MovingPart& b;
  bool (*visit)(void* context, TrianglePair pair);
  void* context;
  bool stopped = false;  ///< by the visitor

  /// Returns false if the visitor stopped it or the steps ended.
  bool run(double margin, std::int64_t steps) {
    if (!a.shape->has_fine() || !b.shape->has_fine()) return true;
    const FineLease lease_a(*a.shape), lease_b(*b.shape);
    const double distance =
        required_distance(a.shape->frame, a.motion, b.shape->frame, b.motion, margin + a.slack + b.slack) +
        a.shape->error_in_world(a.motion.scale) + b.shape->error_in_world(b.motion.scale);
    return visit_near_triangles(
        {a.shape->fine, a.motion.scale}, {b.shape->fine, b.motion.scale},
        pair_motion(a.shape->frame, a.motion, b.shape->frame, b.motion), distance, Effort::full,
        [](void* c, std::int32_t i, std::int32_t j) {
          auto& pairs = *static_cast<PartTrianglePairs*>(c);
          pairs.stopped = !pairs.visit(pairs.context, {pairs.a.first_triangle + i, pairs.b.first_triangle + j});
          return !pairs.stopped;
        },
        this, &steps);
  }
};

}  // namespace

Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  const PairOptions& options) noexcept {
  if (!is_usable(motion_a) || !is_usable(motion_b) || !(options.margin >= 0)) return {.usable = false};
  if (options.boxes && body_boxes_apart(a, motion_a, b, motion_b, options.margin)) return {true, Stage::box, -1};
  if (!a.is_compound() && !b.is_compound()) {
    return simple_separated(a.simple(), motion_a, b.simple(), motion_b, options);
  }
  PartsVerdict verdict;
  for_each_part_pair(a, motion_a, b, motion_b, options.margin, [&](const MovingPart& part_a, const MovingPart& part_b) {
    PairOptions part_options = options;
    part_options.margin += part_a.slack + part_b.slack;
    return verdict.add(simple_separated(*part_a.shape, part_a.motion, *part_b.shape, part_b.motion, part_options));
  });
  return verdict.all();
}

Verdict separated(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                  double margin) noexcept {
  return separated(a, motion_a, b, motion_b, PairOptions{.margin = margin});
}

Verdict separated(const Shape& a, const Motion& motion_a, const HalfSpace& plane, double margin) noexcept {
  if (!is_usable(motion_a) || !(margin >= 0)) return {.usable = false};
  PartsVerdict verdict;
  for_each_part(a, motion_a,
                [&](const MovingPart& part) { return verdict.add(simple_separated(part, plane, margin)); });
  return verdict.all();
}

VisitEnd visit_triangle_pairs(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                              const TrianglePairOptions& options, bool (*visit)(void* context, TrianglePair pair),
                              void* context) {
  const auto refuse = [](const std::string& reason) { throw Error("triangle pairs: " + reason); };
  if (!is_usable(motion_a)) refuse("body a: " + motion_defect(motion_a));
  if (!is_usable(motion_b)) refuse("body b: " + motion_defect(motion_b));
  if (!(options.margin >= 0)) refuse("the margin " + number_text(options.margin) + " is negative or not a number");
  if (options.most_steps < 0) refuse("most_steps is " + std::to_string(options.most_steps) + ", below 0");
  VisitEnd end = VisitEnd::complete;
  for_each_part_pair(a, motion_a, b, motion_b, options.margin, [&](const MovingPart& part_a, const MovingPart& part_b) {
    PartTrianglePairs pairs{part_a, part_b, visit, context};
    if (pairs.run(options.margin, options.most_steps)) return true;
    end = pairs.stopped ? VisitEnd::stopped : VisitEnd::exhausted;
    return false;
  });
  return end;
}

bool visit_triangle_pairs(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b, double margin,
                          bool (*visit)(void* context, TrianglePair pair), void* context) {
  constexpr std::int64_t unlimited = std::numeric_limits<std::int64_t>::max();
  const TrianglePairOptions options{.margin = margin, .most_steps = unlimited};
  return visit_triangle_pairs(a, motion_a, b, motion_b, options, visit, context) == VisitEnd::complete;
}

}  // namespace encage
