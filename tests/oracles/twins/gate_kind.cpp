// SPDX-License-Identifier: GPL-3.0-or-later
// BoxGate: the boxes of two trees.
#include "broadphase/separation/box_gate.h"
#include "oracles/meshes.h"
#include "oracles/sample_trees.h"
#include "oracles/sampled.h"
#include "oracles/twins/pair_kind.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace encage::twins {

using test::Real;
using test::RealTriangle;
using test::SampleTree;
using test::TwinRandom;
using Vector = Eigen::Vector3d;

namespace {

/// Meshes of size 1: with faces across the axes or askew to them, flat, thin, degenerate, off the local origin.
std::vector<TriangleMesh> gate_meshes() {
  return {shapes::torus(1, 0.35, 6, 3),
          shapes::sphere(1),
          shapes::box({-1, -0.6, 0}, {1, 0.6, 0}),
          shapes::box({-1, 0, 0}, {1, 0, 0}),
          shapes::box({-1, -1e-5, -1e-5}, {1, 1e-5, 1e-5}),
          shapes::mesh({{0.3, 0, 1}, {-1, 0.2, 0}, {0, 1, 0}}, {{0, 1, 2}}),
          shapes::mesh({{0.25, 0.5, 0.125}}, {{0, 0, 0}}),
          shapes::moved(shapes::cube(0.5), {3, -2, 1}),
          test::sheet(3, 0, 1)};
}

class GatePairs : public PairKind {
 public:
  Outcome ask(TwinRandom& random, std::int64_t) const override {
    // The sizes range from the smallest to the largest that float32 represents.
    const double size = std::array{1.0, 1.0, 1.0, 1.0, 1e-20, 1e-30, 1e-37, 1e30, 6e37}[random.below(9)];
    const bool moved = size == 1 && random.below(4) == 0;
    const SampleTree a = tree(random, size, moved), b = tree(random, size * unlike(random), moved);
    const auto triangle = [&](const SampleTree& t) {
      return static_cast<std::int64_t>(random.below(static_cast<unsigned>(t.mesh.triangles.rows())));
    };
    const std::int64_t i = triangle(a), j = triangle(b);
    const double meeting = std::array{0.0, 1.0, random.uniform(0, 1)}[random.below(3)];
    PairMotion motion = step(random, a, i, b, j, meeting, size);
    std::vector<Real> times = {0, 1, meeting};
    if (random.below(4) == 0) {
      // An interval of the step, in which the maps are not rotations.
      motion = motion.part(0.5 * meeting, 0.5 + 0.5 * meeting);
      times = {0, 1, 0.5L};
    }
    for (int k = 0; k < 3 && !motion.at_rest; ++k) times.push_back(random.uniform(0, 1));
    if (motion.at_rest) times = {0};
    return compare(random, a, i, b, j, motion, times, size);
  }

 private:
  static double unlike(TwinRandom& random) { return random.below(4) == 0 ? std::pow(10.0, -random.uniform(0, 4)) : 1; }

  SampleTree tree(TwinRandom& random, double factor, bool moved) const {
    TriangleMesh mesh = meshes_[random.below(static_cast<unsigned>(meshes_.size()))];
    mesh = shapes::scaled(mesh, factor);
    return SampleTree(moved ? shapes::moved(mesh, random.point(1e6)) : mesh);
  }

  static Vector point_in(TwinRandom& random, const SampleTree& tree, std::int64_t triangle) {
    const double u = random.coin() ? 0 : random.uniform(0, 1), v = random.uniform(0, 1 - u);
    const TriangleMesh& m = tree.mesh;
    return (1 - u - v) * m.corner(triangle, 0) + u * m.corner(triangle, 1) + v * m.corner(triangle, 2);
  }

  /// Returns no gap, a tiny one, or one so wide that boxes are apart.
  static Vector random_gap(TwinRandom& random, double size) {
    switch (random.below(3)) {
      case 0: return Vector::Zero();
      case 1: return random.point(std::pow(10.0, -random.uniform(0.5, 8)) * size);
      default: return random.direction() * random.uniform(0.5, 5) * size;
    }
  }

  /// Returns a step in which points of both triangles meet, or almost meet, at some time.
  static PairMotion step(TwinRandom& random, const SampleTree& a, std::int64_t i, const SampleTree& b, std::int64_t j,
                         double t, double size) {
    const double angle = random.below(3) == 0 ? 3.12 : 0.3, way = random.coin() ? 2 : 0.2;
    const auto turn = [&](double most) {
      return Eigen::AngleAxisd(random.uniform(-most, most), random.direction()).toRotationMatrix();
    };
    PairMotion motion;
    motion.at_rest = random.below(4) == 0;
    motion.b[0].linear = random.below(4) == 0 ? random.quarter_turns() : turn(3.1);
    motion.a[1].linear = motion.at_rest ? motion.a[0].linear : turn(angle);
    motion.b[1].linear = motion.at_rest ? motion.b[0].linear : turn(angle) * motion.b[0].linear;
    const auto mean = [&](const std::array<AffineMap, 2>& maps, const Vector& v) -> Vector {
      return (1 - t) * maps[0](v) + t * maps[1](v);
    };
    const Vector gap = random_gap(random, size);
    const Vector meet = mean(motion.a, point_in(random, a, i)) - mean(motion.b, point_in(random, b, j)) + gap;
    const Vector by = motion.at_rest ? Vector::Zero() : random.point(way * size);
    motion.b[0].offset = meet - t * by;
    motion.b[1].offset = motion.at_rest ? meet : meet + (1 - t) * by;
    return motion;
  }

  using Posed = std::vector<std::vector<RealTriangle>>;  // indexed by time

  static Posed posed(const SampleTree& tree, const std::array<AffineMap, 2>& maps, const std::vector<Real>& times) {
    Posed result;
    for (const Real t : times) {
      std::vector<RealTriangle>& all = result.emplace_back();
      for (std::int64_t f = 0; f < tree.mesh.triangles.rows(); ++f) {
        RealTriangle triangle;
        for (int k = 0; k < 3; ++k) {
          const test::Point x = tree.mesh.corner(f, k).cast<Real>();
          const auto end = [&](int e) -> test::Point {
            return maps[e].linear.cast<Real>() * x + maps[e].offset.cast<Real>();
          };
          triangle[k] = (1 - t) * end(0) + t * end(1);
        }
        all.push_back(triangle);
      }
    }
    return result;
  }

  /// Least distance over the times; any larger value if it exceeds `limit`.
  static Real least(const Posed& a, std::int64_t i, const Posed& b, std::int64_t j, Real limit) {
    Real value = std::numeric_limits<Real>::infinity();
    for (std::size_t s = 0; s < a.size(); ++s) {
      if (test::distance_bound(a[s][i], b[s][j]) <= limit)
        value = std::min(value, test::triangle_distance(a[s][i], b[s][j]));
    }
    return value;
  }

  static bool all_farther(const Posed& a, const Posed& b, Real distance) {
    for (std::size_t i = 0; i < a[0].size(); ++i) {
      for (std::size_t j = 0; j < b[0].size(); ++j) {
        if (least(a, static_cast<std::int64_t>(i), b, static_cast<std::int64_t>(j), distance) <= distance) return false;
      }
    }
    return true;
  }

  static std::vector<bool> visited(const SampleTree& a, const SampleTree& b, const BoxGate& gate) {
    struct Context {
      const SampleTree &a, &b;
      std::vector<bool> found;
    } context{a, b, std::vector<bool>(static_cast<std::size_t>(a.mesh.triangles.rows() * b.mesh.triangles.rows()))};
    visit_leaf_pairs(
        a.arrays.tree, b.arrays.tree, gate,
        [](void* c, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
          auto& [tree_a, tree_b, found] = *static_cast<Context*>(c);
          for (std::int32_t i = first_a; i < first_a + count_a; ++i) {
            for (std::int32_t j = first_b; j < first_b + count_b; ++j) {
              const std::int64_t row = tree_a.arrays.tree.leaves[i].triangle;
              found[static_cast<std::size_t>(row * tree_b.mesh.triangles.rows() +
                                             tree_b.arrays.tree.leaves[j].triangle)] = true;
            }
          }
          return true;
        },
        &context);
    return context.found;
  }

  /// Checks that every pair of triangles that is not visited is farther apart than the given distance.
  static Outcome compare(TwinRandom& random, const SampleTree& a, std::int64_t picked_a, const SampleTree& b,
                         std::int64_t picked_b, const PairMotion& motion, const std::vector<Real>& times, double size) {
    const Posed posed_a = posed(a, motion.a, times), posed_b = posed(b, motion.b, times);
    // The distance is chosen so that some pair barely has to be visited, or it is tiny.
    const Real infinity = std::numeric_limits<Real>::infinity();
    const auto picked = static_cast<double>(least(posed_a, picked_a, posed_b, picked_b, infinity));
    const double distance = random.coin() ? 1e-9 * size : picked * (1 + 1e-12) + 1e-300;
    const std::vector<bool> found = visited(a, b, {motion, a.body(), b.body(), distance});
    Outcome outcome{.rejected = std::none_of(found.begin(), found.end(), [](bool x) { return x; }), .sampled = true};
    Real nearest = infinity;
    for (std::int64_t i = 0; i < a.mesh.triangles.rows(); ++i) {
      for (std::int64_t j = 0; j < b.mesh.triangles.rows(); ++j) {
        // For the visited pairs it suffices to know whether some are near.
        const bool absent = !found[static_cast<std::size_t>(i * b.mesh.triangles.rows() + j)];
        if (!absent && nearest <= distance) continue;
        const Real value = least(posed_a, i, posed_b, j, distance);
        nearest = std::min(nearest, value);
        if (absent && !(value > static_cast<Real>(distance) * (1 - 1e-15L))) outcome.missed = true;
      }
    }
    outcome.truth = nearest <= 0 ? Truth::touching : nearest <= distance ? Truth::within_margin : Truth::apart;
    // Boxes of leaves are as large as their triangles; callers cut steps into parts as short as this.
    outcome.far = outcome.truth == Truth::apart && size > 1e-32 && size < 1e20 && a.radius < 10 * size &&
                  b.radius < 10 * size &&
                  motion.displacement(a.radius, b.radius) <= 0.25 * std::min(a.radius, b.radius) &&
                  all_farther(posed_a, posed_b, distance + size);
    if (outcome.missed) outcome.what = "sizes " + std::to_string(a.radius) + " and " + std::to_string(b.radius);
    return outcome;
  }

  std::vector<TriangleMesh> meshes_ = gate_meshes();
};

}  // namespace

std::unique_ptr<PairKind> gate_pairs() { return std::make_unique<GatePairs>(); }

}  // namespace encage::twins
