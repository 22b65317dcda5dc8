// SPDX-License-Identifier: GPL-3.0-or-later
// Points in solids.
#include "broadphase/separation/containment.h"
#include "oracles/exact_pair.h"
#include "oracles/meshes.h"
#include "oracles/twins/pair_kind.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace encage::twins {

using test::TwinRandom;
using Vector = Eigen::Vector3d;

namespace {

/// Where a point lies with respect to a mesh or a cage; rejected: outside.
class Points : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t) const override {
    const test::Body& body = random.one_of(bodies_);
    const auto& levels = body.sample.hierarchy.levels;
    const unsigned level = random.below(static_cast<unsigned>(levels.size()) + 1);
    const bool fine = level == levels.size();
    const TriangleMesh& mesh = fine ? body.sample.hierarchy.fine : levels[level].mesh;
    const Surface& surface = fine ? body.shape->simple().fine : body.shape->simple().cages[level];
    if (surface.empty() || !surface.closed) return {};
    const Vector p = point(random, body, mesh);

    const test::ExactBody exact(Vector::Zero(), mesh, Eigen::Isometry3d::Identity());
    const test::ExactBody probe(Vector::Zero(), shapes::mesh({{p.x(), p.y(), p.z()}}, {{0, 0, 0}}),
                                Eigen::Isometry3d::Identity());
    Outcome outcome{.rejected = locate(surface, p) == Side::outside, .sampled = true, .truth = Truth::apart};
    // On the surface there is no winding number: any answer will do.
    if (surfaces_meet(exact, probe, 0)) return {.rejected = outcome.rejected};
    if (winding_number(exact, p) != 0) outcome.truth = Truth::touching;
    outcome.missed = outcome.rejected && outcome.truth == Truth::touching;
    if (outcome.missed) outcome.what = body.sample.name + ", level " + std::to_string(level);
    outcome.far = outcome.truth == Truth::apart && !surfaces_meet(exact, probe, 1e-6 * body.diagonal());
    return outcome;
  }

 private:
  /// Anywhere, on a lattice, near the surface, or on a ray that meets a vertex or an edge.
  static Vector point(TwinRandom& random, const test::Body& body, const TriangleMesh& mesh) {
    const double size = 0.5 * body.diagonal();
    const Vector any = random.point(size);
    const auto t = static_cast<std::int64_t>(random.below(static_cast<unsigned>(mesh.triangles.rows())));
    const Vector corner = mesh.corner(t, 0), middle = 0.5 * (corner + mesh.corner(t, 1));
    switch (random.below(4)) {
      case 0: return any;
      case 1: return (any * (8 / size)).array().round() * (size / 8);
      case 2: {
        const double u = random.uniform(0, 1), v = random.uniform(0, 1 - u);
        return (1 - u - v) * corner + u * mesh.corner(t, 1) + v * mesh.corner(t, 2) +
               random.direction() * std::pow(10.0, -random.uniform(1, 16)) * size;
      }
      default: {
        const WindingRay& ray = rays[random.below(rays.size())];
        Vector direction;
        direction[ray.axis] = 1;
        direction[(ray.axis + 1) % 3] = ray.slope1;
        direction[(ray.axis + 2) % 3] = ray.slope2;
        return (random.coin() ? corner : middle) - random.uniform(0.05, 1.2) * size * direction;
      }
    }
  }

  std::vector<test::Body> bodies_ = [] {
    std::vector<test::Body> all = test::twin_bodies();
    for (const int exponent : {-60, 60}) {
      for (test::Body& body : test::twin_bodies(exponent)) all.push_back(std::move(body));
    }
    return all;
  }();
};

}  // namespace

std::unique_ptr<PairKind> points() { return std::make_unique<Points>(); }

}  // namespace encage::twins
