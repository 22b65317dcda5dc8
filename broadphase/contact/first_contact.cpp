// SPDX-License-Identifier: Apache-2.0
#include "broadphase/distance/surface_distance.h"
#include "broadphase/separation/plane_check.h"
#include "broadphase/separation/surface_pair.h"
#include "broadphase/shape/compound.h"

#include <encage/contact.h>
#include <encage/error.h>
#include <encage/primitives.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace encage {

/// Passes pairs of nearby triangles to the narrow phase, interval by interval, until it is done or has taken its budget
/// of work. A quarter of it is for ties, contacts that begin as early as the first one: each may be the result.
class ENCAGE_HIDDEN FirstContactSearch {
 public:
  FirstContactSearch(PairContact& narrow, const ContactOptions& options)
      : narrow_(narrow), options_(options), steps_(options.most_steps), steps_for_ties_(options.most_steps / 4) {
    steps_ -= steps_for_ties_;
  }

  void search(const MovingPart& a, const MovingPart& b) {
    const FineLease lease_a(*a.shape), lease_b(*b.shape);
    // These parts may use what the ones before have left; there is always enough for parts that are not hard.
    steps_ = std::max(steps_, std::min(options_.most_steps / 2, least_steps));
    Parts(*this, a, b).search(0, 1);
  }

 private:
  static constexpr double tick = PairContact::tick;
  static constexpr std::int64_t least_steps = 1 << 14;

  class Parts {
   public:
    Parts(FirstContactSearch& all, const MovingPart& a, const MovingPart& b)
        : all_(all),
          narrow_(all.narrow_),
          first_a_(a.first_triangle),
          first_b_(b.first_triangle),
          a_(a.shape->fine, a.motion.scale),
          b_(b.shape->fine, b.motion.scale),
          motion_(pair_motion(a.shape->frame, a.motion, b.shape->frame, b.motion)),
          steps_of_interval_(all.options_.most_steps / 128) {
      const auto required = [&](double margin) {
        return required_distance(a.shape->frame, a.motion, b.shape->frame, b.motion, margin);
      };
      // Every contact of the narrow phase must pass the culling, whichever way the pair was found. So rounding is
      // included twice, and what moves while its times are uncertain.
      rounding_ = required(0);
      distance_ = required(all.options_.margin + a.slack + b.slack + a.shape->contact_margin(a.motion.scale) +
                           b.shape->contact_margin(b.motion.scale)) *
                      (1 + 0x1p-40) +
                  rounding_ + uncertain * motion_.displacement(a_.radius(), b_.radius());
    }

    /// Searches an interval. Returns false where the budget ends.
    bool search(double t0, double t1) {
      if (t0 > narrow_.latest()) return true;
      const PairMotion part = motion_.part(t0, t1);
      if (balls_apart(a_, b_, part, required(t0, t1))) return true;
      const double longest_way = 0.25 * std::max(std::min(a_.radius(), b_.radius()), distance_);
      if (t1 - t0 <= shortest || !(part.displacement(a_.radius(), b_.radius()) > longest_way)) {
        // Arcs rise during an interval, and bodies come near: without them, few intervals are worth dividing.
        return visit(t0, t1, all_.options_.arc > 0 ? steps_of_interval_ : all_.options_.most_steps / 8);
      }
      const double middle = 0.5 * (t0 + t1);
      return search(t0, middle) && search(middle, t1);
    }

   private:
    static constexpr double shortest = 0x1p-8;
    static constexpr double briefest = 0x1p-16;  // boxes prove no more in shorter intervals: they are computed in float
    static constexpr double uncertain = 0x1p-20;

    /// A larger distance during [t0, t1] proves absence of contact then.
    double required(double t0, double t1) const {
      const double t = std::clamp(0.5, t0 - uncertain, t1 + uncertain);  // when the arcs are highest
      return distance_ + all_.options_.arc * (1 + 0x1p-40) * std::max(0.0, 4 * t * (1 - t));
    }

    /// Visits the pairs of triangles that are near in the interval. Where that takes long, halves of the interval do
    /// with fewer: bodies come less far, and arcs rise less. What is left of the budget is for the briefest interval.
    bool visit(double t0, double t1, std::int64_t most_steps) {
      bool last = false;
      do {
        if (t0 > narrow_.latest()) return true;
        t1 = std::min(t1, narrow_.latest() + 8 * tick);
        const bool halves_alike = motion_.at_rest && all_.options_.arc == 0;
        last = halves_alike || t1 - t0 <= briefest || most_steps >= all_.steps_;
        const std::int64_t allowed = last ? all_.steps_ : most_steps;
        left_ = allowed;
        const bool finished = visit_near_triangles(
            a_, b_, motion_.part(t0, t1), required(t0, t1), Effort::quick,
            [](void* parts, std::int32_t i, std::int32_t j) { return static_cast<Parts*>(parts)->test(i, j); }, this,
            &left_);
        all_.steps_ -= allowed - left_;
        if (finished) {
          // An interval that needed most of its steps shows that the next ones need more: that saves divisions.
          if (2 * (allowed - left_) > steps_of_interval_) steps_of_interval_ *= 2;
          return true;
        }
      } while (left_ >= 0);  // the visitor stopped it, since only earlier contacts count from now on
      if (last) {
        give_up(t0);
        return false;
      }
      const double middle = 0.5 * (t0 + t1);
      return visit(t0, middle, steps_of_interval_) && visit(middle, t1, steps_of_interval_);
    }

    /// Returns false to stop the visits.
    bool test(std::int32_t triangle_a, std::int32_t triangle_b) {
      const double latest = narrow_.latest();
      const std::int64_t steps = narrow_.steps_, contacts = narrow_.contacts_;
      narrow_.test(first_a_ + triangle_a, first_b_ + triangle_b);
      const std::int64_t taken = narrow_.steps_ - steps;
      // Shorter intervals do not leave out triangles that touch when the first contact begins.
      const bool tie = narrow_.contacts_ > contacts && narrow_.first() && narrow_.first()->time >= latest - 8 * tick;
      if (!tie || narrow_.ignores_ties_) {
        left_ -= taken;
        return left_ >= 0;
      }
      all_.steps_for_ties_ -= taken;
      if (all_.steps_for_ties_ >= 0) return true;
      narrow_.ignore_ties();
      return false;
    }

    /// Takes the time up to which absence of contact is proven for that of the first contact.
    void give_up(double t) {
      const PairMotion then = motion_.part(t, t);
      const RestingPair pair(then.a[0], a_.scale(), then.b[0], b_.scale(), rounding_);
      std::int64_t steps = least_steps;
      const SurfaceDistance nearest = surface_distance(a_, b_, pair, {.tolerance = 0.1, .steps = &steps});
      narrow_.suppose(first_a_ + std::max(0, nearest.triangle_a), first_b_ + std::max(0, nearest.triangle_b),
                      std::floor(t / tick) * tick);
    }

    FirstContactSearch& all_;
    PairContact& narrow_;
    std::int32_t first_a_, first_b_;
    ScaledSurface a_, b_;
    PairMotion motion_;
    double rounding_, distance_;
    std::int64_t steps_of_interval_;
    std::int64_t left_ = 0;  // of the steps for the current interval
  };

  PairContact& narrow_;
  const ContactOptions& options_;
  std::int64_t steps_, steps_for_ties_;
};

namespace {

auto order(const Contact& c) { return std::tie(c.time, c.kind, c.vertices); }

void contact_with_plane(const MovingPart& a, const HalfSpace& plane, const ContactOptions& options,
                        std::optional<Contact>& first) {
  const double margin = options.margin + a.slack;
  if (a.shape->on_demand && PlaneCheck(*a.shape, a.motion, plane, margin, options.arc).beyond_throughout()) return;
  const FineLease lease(*a.shape);
  const PlaneCheck check(*a.shape, a.shape->fine, a.motion, plane, margin, options.arc);
  if (check.beyond_throughout()) return;
  bool overlapping = first && first->overlapping;
  check.visit_reaching([&](std::int32_t vertex, double time) {
    if (time > (first ? first->time : options.latest)) return;
    const Eigen::Vector3d x = a.motion.scale * (a.shape->frame.origin + a.shape->fine.vertex(vertex));
    const Eigen::Vector3d start = a.motion.start * x;
    // Positions, products and sums round by a few units of what they are made of.
    const double radius = a.motion.scale * a.shape->convex_radius;
    const double error = a.shape->primitive ? a.shape->core_error_in_world(a.motion.scale) : 0;
    const double size = x.lpNorm<1>() + a.motion.start.translation().lpNorm<1>() + std::abs(plane.offset) + radius;
    overlapping |= time == 0 && plane.normal.dot(start) - plane.offset <
                                    a.shape->least_radius(a.motion.scale) - error - 0x1p-46 * size - a.slack;
    Contact contact;
    contact.time = time;
    contact.kind = ContactKind::vertex_plane;
    contact.vertices = {a.first_vertex + vertex, -1, -1, -1};
    if (first && order(*first) <= order(contact)) return;
    contact.point = (1 - time) * start + time * (a.motion.end * x) - radius * plane.normal;
    contact.normal = plane.normal;
    first = contact;
  });
  if (overlapping) first->overlapping = true;
}

}  // namespace

std::optional<Contact> first_contact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                                     const ContactOptions& options) {
  PairContact narrow(a, motion_a, b, motion_b, options);
  FirstContactSearch search(narrow, options);
  // Parts that boxes separate by this distance cannot be in contact for the narrow phase: required_distance() is below
  // it for all poses.
  const double size = size_in_world(a, motion_a) + size_in_world(b, motion_b) + motion_a.scale * convex_radius(a) +
                      motion_b.scale * convex_radius(b);
  const double margin = 2 * ((1 + 1e-6) * options.margin + options.arc) + 1e-6 * size;
  for_each_part_pair(a, motion_a, b, motion_b, margin, [&](const MovingPart& part_a, const MovingPart& part_b) {
    search.search(part_a, part_b);
    return true;
  });
  return narrow.first();
}

std::optional<Contact> first_contact(const Shape& a, const Motion& motion_a, const HalfSpace& plane,
                                     const ContactOptions& options) {
  if (!is_usable(motion_a)) throw Error("first contact: body a: " + motion_defect(motion_a));
  std::optional<Contact> first;
  for_each_part(a, motion_a, [&](const MovingPart& part) {
    contact_with_plane(part, plane, options, first);
    return true;
  });
  return first;
}

}  // namespace encage
