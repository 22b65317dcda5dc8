// SPDX-License-Identifier: GPL-3.0-or-later
// Queries about two bodies.
#include "oracles/twins/scenes.h"

#include <encage/world.h>

#include <string>
#include <vector>

namespace encage::twins {

using test::Body;
using test::TwinRandom;

namespace {

bool rejected(const Scene& scene) { return scene.ask().separated; }

bool shows_rate(const Scene& scene) { return test::shows_rate(*scene.a, *scene.b) && scene.well_conditioned(); }

/// What a wrong reject tells.
std::string verdict_text(const Scene& scene) {
  const Verdict verdict = scene.ask();
  return scene.text() + ", stage " + std::to_string(static_cast<int>(verdict.stage)) + ", level " +
         std::to_string(verdict.level);
}

/// The truth about every reject, and about sampled pairs in any case.
template <class Brute>
Outcome judge(const Scene& scene, bool rejects, bool sampled) {
  Outcome outcome{.rejected = rejects, .sampled = sampled};
  if (!rejects && !sampled) return outcome;
  outcome.close = rejects && !scene.ask(1e-4 * scene.size()).separated;
  const Brute brute(scene);
  outcome.truth = brute.truth();
  outcome.missed = rejects && outcome.truth != Truth::apart;
  if (outcome.missed) outcome.what = verdict_text(scene);
  if (sampled && outcome.truth == Truth::apart && shows_rate(scene)) {
    outcome.far = brute.farther(scene.one_per_cent());
  }
  return outcome;
}

class RestingPairs : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t number) const override {
    const Scene scene = scenes_.resting(random, number, rejected);
    return judge<RestingTruth>(scene, rejected(scene), number % 7 == 0);
  }

 private:
  Scenes scenes_{Scenes::Bodies::all, true};
};

class MovingPairs : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t number) const override {
    const Scene scene = scenes_.moving(random, number, rejected);
    return judge<MovingTruth>(scene, rejected(scene), number % 10 == 0);
  }

 private:
  Scenes scenes_{Scenes::Bodies::all, true};
};

/// The pair in a world with a third body, which has been searched in other places before.
class WorldPairs : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t number) const override {
    const bool moves = random.coin();
    const Scene scene = moves ? scenes_.moving(random, number, rejected) : scenes_.resting(random, number, rejected);
    World world;
    CandidateOptions options;
    // Part of the margin is the bodies' own.
    const double own = random.coin() ? 0 : 0.25 * scene.margin;
    options.pair.margin = scene.margin - 2 * own;
    const BodyOptions of_a{.margin = own, .scale = scene.motion_a.scale},
        of_b{.margin = own, .scale = scene.motion_b.scale};
    const BodyId a = world.add_body(world.add_shape(scene.a->shape), scene.motion_a.start, of_a);
    const BodyId b = world.add_body(world.add_shape(scene.b->shape), elsewhere(random, scene), of_b);
    world.add_body(world.add_shape(scene.b->shape), elsewhere(random, scene));
    if (random.coin()) world.find_candidates(options, [](const CandidatePair&) {});
    world.set_motion(a, scene.motion_a);
    world.set_motion(b, scene.motion_b);
    bool found = false;
    world.find_candidates(options, [&](const CandidatePair& pair) { found = found || (pair.a == a && pair.b == b); });
    const bool sampled = number % 10 == 0;
    return moves ? judge<MovingTruth>(scene, !found, sampled) : judge<RestingTruth>(scene, !found, sampled);
  }

 private:
  static Eigen::Isometry3d elsewhere(TwinRandom& random, const Scene& scene) {
    Eigen::Isometry3d pose = scene.motion_b.start;
    pose.translation() += random.direction() * random.uniform(0, 4) * scene.size();
    return pose;
  }

  Scenes scenes_{Scenes::Bodies::all, false};
};

/// Every pair of triangles that comes within the margin has to be among the candidates.
class CandidatePairs : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t number) const override {
    const auto none = [](const Scene& scene) { return visit(scene, [](TrianglePair) { return false; }); };
    const bool moves = number % 3 != 0;
    const Scene scene = moves ? scenes_.moving(random, number, none) : scenes_.resting(random, number, none);
    const auto columns = scene.b->mesh().triangles.rows();
    std::vector<bool> known(static_cast<std::size_t>(scene.a->mesh().triangles.rows() * columns));
    Outcome outcome{.rejected = true, .sampled = number % 10 == 0};
    visit(scene, [&](TrianglePair pair) {
      known[static_cast<std::size_t>(pair.a * columns + pair.b)] = true;
      outcome.rejected = false;
      return true;
    });
    if (moves) {
      compare(MovingTruth(scene), known, outcome, scene);
    } else {
      compare(RestingTruth(scene), known, outcome, scene);
    }
    if (outcome.missed) outcome.what = scene.text();
    return outcome;
  }

 private:
  template <class Visit>
  static bool visit(const Scene& scene, Visit&& call) {
    return for_each_triangle_pair(*scene.a->shape, scene.motion_a, *scene.b->shape, scene.motion_b, scene.margin, call);
  }

  static void compare(const MovingTruth& truth, const std::vector<bool>& known, Outcome& outcome, const Scene& scene) {
    outcome.missed = truth.near_triangles_but(known);
    if (!outcome.sampled) return;
    outcome.truth = truth.surface_truth();
    outcome.far =
        outcome.truth == Truth::apart && scene.well_conditioned() && truth.surfaces_farther(scene.one_per_cent());
  }

  static void compare(const RestingTruth& truth, const std::vector<bool>& known, Outcome& outcome, const Scene& scene) {
    const auto columns = static_cast<std::size_t>(scene.b->mesh().triangles.rows());
    for (std::size_t p = 0; p < known.size() && !outcome.missed; ++p) {
      outcome.missed = !known[p] && truth.triangles_near(static_cast<std::int64_t>(p / columns),
                                                         static_cast<std::int64_t>(p % columns));
    }
    if (!outcome.sampled) return;
    outcome.truth = truth.surfaces_near(0)              ? Truth::touching
                    : truth.surfaces_near(scene.margin) ? Truth::within_margin
                                                        : Truth::apart;
    outcome.far = outcome.truth == Truth::apart && scene.well_conditioned() && truth.farther(scene.one_per_cent());
  }

  Scenes scenes_{Scenes::Bodies::with_fine_mesh, true};
};

}  // namespace

std::unique_ptr<PairKind> resting_pairs() { return std::make_unique<RestingPairs>(); }
std::unique_ptr<PairKind> moving_pairs() { return std::make_unique<MovingPairs>(); }
std::unique_ptr<PairKind> world_pairs() { return std::make_unique<WorldPairs>(); }
std::unique_ptr<PairKind> candidate_pairs() { return std::make_unique<CandidatePairs>(); }

}  // namespace encage::twins
