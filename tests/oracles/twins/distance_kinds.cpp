// SPDX-License-Identifier: GPL-3.0-or-later
// Distances of bodies and of triangles: bounds must be correct to the last bit.
#include "broadphase/distance/triangle_distance.h"
#include "oracles/exact_pair.h"
#include "oracles/twins/delicate.h"
#include "oracles/twins/scenes.h"

#include <encage/distance.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace encage::twins {

using test::TwinRandom;
using Vector = Eigen::Vector3d;

namespace {

double below(double x) { return std::nextafter(x, 0.0); }

class BodyDistances : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t number) const override {
    const auto farther = [](const Scene& scene) { return ask_distance(scene, {}).lower > scene.margin; };
    const Scene scene = scenes_.resting(random, number, farther);
    const double usual = scene.size() * std::pow(10.0, -random.uniform(-1, 4));
    DistanceOptions options;
    if (random.below(3) == 0) options.limit = usual;
    if (random.below(3) == 0) options.tolerance = random.uniform(0, 1);
    if (random.below(3) == 0) options.hint = {some_triangle(random, *scene.a), some_triangle(random, *scene.b)};
    CageDistanceOptions cages{.tolerance = random.coin() ? 0 : random.uniform(0, 1)};
    if (random.below(3) == 0) cages.enough = usual;
    if (random.coin()) cages.finest_cage = static_cast<int>(random.below(3));
    if (random.coin()) cages.coarsest_cage = static_cast<int>(random.below(3));

    const DistanceResult found = ask_distance(scene, options);
    const double bound = cage_distance_bound(*scene.a->shape, scene.motion_a, *scene.b->shape, scene.motion_b, cages);
    Outcome outcome{.rejected = ask_distance(scene, {}).lower > scene.margin, .sampled = true};
    const RestingTruth truth(scene);
    outcome.truth = truth.truth();
    const bool touching = outcome.truth == Truth::touching;
    const double lower = std::max(found.lower, bound);
    const bool too_large = lower > 0 && (touching || truth.surfaces_near(below(lower)));
    const bool too_small = !std::isinf(found.upper) && !touching && !truth.surfaces_near(found.upper);
    outcome.missed = too_large || too_small || (outcome.rejected && outcome.truth != Truth::apart);
    if (outcome.missed) outcome.what = text(scene, found, bound);
    outcome.far = outcome.truth == Truth::apart && test::shows_rate(*scene.a, *scene.b) && scene.well_conditioned() &&
                  truth.farther(scene.one_per_cent());
    return outcome;
  }

 private:
  static DistanceResult ask_distance(const Scene& scene, const DistanceOptions& options) {
    return distance(*scene.a->shape, scene.motion_a, *scene.b->shape, scene.motion_b, options);
  }

  /// Returns a random triangle, sometimes an invalid one.
  static std::int32_t some_triangle(TwinRandom& random, const test::Body& body) {
    return static_cast<std::int32_t>(random.below(static_cast<unsigned>(body.mesh().triangles.rows()) + 1));
  }

  static std::string text(const Scene& scene, const DistanceResult& found, double bound) {
    std::ostringstream out;
    out.precision(17);
    out << scene.text() << ", distance in [" << found.lower << ", " << found.upper << "], by cages " << bound;
    return out.str();
  }

  Scenes scenes_{Scenes::Bodies::all, false};  // without large bodies, whose answers would take seconds to prove
};

class TriangleDistances : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t) const override {
    const auto [a, b, setting] = random_triangle_pair(random);
    double norm = 0;
    for (int k = 0; k < 3; ++k) norm = std::max({norm, a[k].norm(), b[k].norm()});
    const double error = 16 * std::numeric_limits<double>::epsilon() * norm;
    const TriangleDistance found = triangle_distance(a, b, error);
    Outcome outcome{.rejected = found.lower > 0, .sampled = true, .truth = Truth::apart};
    if (test::triangles_meet(a, b, 0)) outcome.truth = Truth::touching;
    const bool too_large = found.lower > 0 && test::triangles_meet(a, b, below(found.lower));
    const bool too_small = !test::triangles_meet(a, b, found.upper);
    // The points are in the triangles up to rounding.
    const bool off = !((found.point_a - found.point_b).norm() <= found.upper);
    const bool crossing = triangles_cross(a, b, error) && outcome.truth == Truth::apart;
    outcome.missed = too_large || too_small || off || crossing;
    if (outcome.missed) outcome.what = text(a) + " and" + text(b) + (crossing ? ", said to cross" : "");
    outcome.far = outcome.truth == Truth::apart && !test::triangles_meet(a, b, 64 * error);
    return outcome;
  }

 private:
  static std::string text(const TriangleD& t) {
    std::ostringstream out;
    out << std::hexfloat;
    for (const Vector& v : t) out << " (" << v.x() << ", " << v.y() << ", " << v.z() << ")";
    return out.str();
  }
};

}  // namespace

std::unique_ptr<PairKind> body_distances() { return std::make_unique<BodyDistances>(); }
std::unique_ptr<PairKind> triangle_distances() { return std::make_unique<TriangleDistances>(); }

}  // namespace encage::twins
