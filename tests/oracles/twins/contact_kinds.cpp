// SPDX-License-Identifier: GPL-3.0-or-later
// Times of first contact, and half-spaces.
#include "oracles/exact_pair.h"
#include "oracles/twins/scenes.h"

#include <encage/contact.h>

#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

namespace encage::twins {

using test::Body;
using test::TwinRandom;

namespace {

/// Compares first_contact() with PairContact over all pairs of triangles, and with the exact time.
class ContactPairs : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t number) const override {
    ContactOptions options;
    if (random.below(4) == 0) options.latest = random.uniform(0, 1);
    const auto free = [&](const Scene& s) {
      options.margin = s.margin;
      return !first(s, options);
    };
    Scene scene = scenes_.moving(random, number, free);
    options.margin = scene.margin;
    if (random.below(4) == 0) options.arc = 0.02 * random.uniform(0, 1) * scene.size();
    const std::optional<Contact> found = first(scene, options);
    Outcome outcome{.rejected = !found, .sampled = number % 8 == 0};
    outcome.missed = !same(found, brute_force(scene, options));
    // The exact time without margin and arc is also a bound with them, as contacts then do not come later.
    if (options.latest == 1 && (!found || outcome.sampled)) compare(scene, found, outcome);
    if (outcome.missed) outcome.what = scene.text() + ", arc " + std::to_string(options.arc);
    return outcome;
  }

 private:
  static std::optional<Contact> first(const Scene& s, const ContactOptions& options) {
    return first_contact(*s.a->shape, s.motion_a, *s.b->shape, s.motion_b, options);
  }

  static std::optional<Contact> brute_force(const Scene& s, const ContactOptions& options) {
    PairContact contact(*s.a->shape, s.motion_a, *s.b->shape, s.motion_b, options);
    for (std::int32_t i = 0; i < s.a->mesh().triangles.rows(); ++i) {
      for (std::int32_t j = 0; j < s.b->mesh().triangles.rows(); ++j) contact.test(i, j);
    }
    return contact.first();
  }

  static bool same(const std::optional<Contact>& x, const std::optional<Contact>& y) {
    if (!x || !y) return !x && !y;
    return x->time == y->time && x->kind == y->kind && x->vertices == y->vertices;
  }

  static void compare(const Scene& scene, const std::optional<Contact>& found, Outcome& outcome) {
    const MovingTruth truth(scene, MovingTruth::Meshes::fine);
    const double latest = truth.latest_first_contact();
    // There is no statement about meshes that intersect at the start.
    if (latest > 0 && latest <= 1 && !(found && found->time <= latest)) outcome.missed = true;
    if (!outcome.sampled) return;
    outcome.truth = latest <= 1 ? Truth::touching : truth.surface_truth();
    // With an arc, contact may be far from the straight paths.
    outcome.far =
        outcome.truth == Truth::apart && scene.well_conditioned() && truth.surfaces_farther(0.03 * scene.size());
  }

  Scenes scenes_{Scenes::Bodies::with_fine_mesh, false};
};

/// A body and a half-space, mostly close to where the answer changes. All vertices are tested exactly.
class PlanePairs : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t number) const override {
    const Body& body = random.one_of(number % 64 == 0 ? large_ : small_);
    const Eigen::Isometry3d pose = random.pose();
    const Motion motion = random.below(3) == 0 ? Motion::resting(pose, body.scale) : random_motion(random, body, pose);
    HalfSpace plane{.normal =
                        random.below(4) == 0 ? Eigen::Vector3d(random.quarter_turns().col(0)) : random.direction()};
    const double margin = random.margin(body, body);
    const auto rejects = [&](double offset) {
      plane.offset = offset;
      return separated(*body.shape, motion, plane, margin).separated;
    };
    const double middle = plane.normal.dot(body.centre(motion.start)), reach = 4 * body.diagonal() + margin;
    if (random.below(4) == 0) {
      plane.offset = middle - random.uniform(-1, 1) * reach;
    } else {
      random.near_change([&](double x) { return rejects(middle + reach - x); }, 2 * reach, body.diagonal());
    }

    const test::ExactBody start(body.origin(), body.sample.source, motion.start, body.scale);
    const test::ExactBody end(body.origin(), body.sample.source, motion.end, body.scale);
    const auto beyond = [&](double distance) {
      return all_beyond(start, plane.normal, plane.offset, distance) &&
             all_beyond(end, plane.normal, plane.offset, distance);
    };
    Outcome outcome{.rejected = rejects(plane.offset), .sampled = true, .truth = Truth::apart};
    if (!beyond(margin)) outcome.truth = margin > 0 && beyond(0) ? Truth::within_margin : Truth::touching;
    // Only the fine mesh has contacts, and its vertices differ from the source's.
    const bool contact = !body.has_fine() ||
                         first_contact(*body.shape, motion, plane,
                                       {.margin = margin + body.scale * body.sample.hierarchy.fine_error * (1 + 1e-8)});
    outcome.missed = outcome.truth != Truth::apart && (outcome.rejected || !contact);
    outcome.far = outcome.truth == Truth::apart && body.has_fine() && beyond(margin + 0.01 * body.diagonal());
    if (outcome.missed) outcome.what = body.sample.name + ", margin " + std::to_string(margin);
    return outcome;
  }

 private:
  std::vector<Body> small_ = test::twin_bodies(), large_ = test::large_twin_bodies();
};

}  // namespace

std::unique_ptr<PairKind> contact_pairs() { return std::make_unique<ContactPairs>(); }
std::unique_ptr<PairKind> plane_pairs() { return std::make_unique<PlanePairs>(); }

}  // namespace encage::twins
