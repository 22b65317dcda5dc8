// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/distance/box_distance.h"

#include "oracles/meshes.h"
#include "oracles/sample_trees.h"
#include "oracles/sampled.h"
#include "oracles/simd_targets.h"
#include "src/tree/mesh_arrays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Leaves = std::tuple<std::int32_t, std::int32_t, std::int32_t, std::int32_t>;

/// Two trees in a common frame.
struct Scene {
  const SampleTree& a;
  const SampleTree& b;
  double scale_a, scale_b;
  AffineMap map_a, map_b;

  Scene(shapes::Random& random, const std::vector<SampleTree>& all)
      : a(all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))]),
        b(all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))]) {
    const double unit = std::array{1.0, 1.0, 1.0, 0x1p-60, 1e30}[static_cast<std::size_t>(random.integer(5))];
    scale_a = unit * (random.integer(3) == 0 ? 0.01 : 1);
    scale_b = unit * (random.integer(3) == 0 ? 7 : 1);
    map_a.linear = random_rotation(random, 3.1);
    map_b.linear = random_rotation(random, 3.1) * (random.integer(3) == 0 ? 1 + 2e-10 : 1);
    const double far = random.integer(4) == 0 ? std::pow(10, random(1, 14)) : random(0, 6);
    map_b.offset = random_direction(random) * far * unit;
  }

  // The maps are used as they are, so only the rounding of the bounds remains.
  BoxDistance bounds() const { return {map_a, a.body(scale_a), map_b, b.body(scale_b), 0}; }
  RealTriangle triangle(bool of_b, std::int32_t leaf) const {
    const SampleTree& tree = of_b ? b : a;
    const AffineMap& map = of_b ? map_b : map_a;
    const Real scale = of_b ? scale_b : scale_a;
    RealTriangle t;
    for (int k = 0; k < 3; ++k) {
      const Point x =
          scale * tree.mesh.corner(tree.arrays.tree.leaves[static_cast<std::size_t>(leaf)].triangle, k).cast<Real>();
      t[static_cast<std::size_t>(k)] = map.linear.cast<Real>() * x + map.offset.cast<Real>();
    }
    return t;
  }
};

struct Visited {
  double limit;
  double after = std::numeric_limits<double>::infinity();  ///< the result of every visit
  std::vector<Leaves> leaves{};

  void run(const Scene& scene) {
    visit_near_leaves(
        scene.a.arrays.tree, scene.b.arrays.tree, scene.bounds(), limit,
        [](void* context, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
          auto& self = *static_cast<Visited*>(context);
          self.leaves.emplace_back(first_a, count_a, first_b, count_b);
          return std::min(self.limit, self.after);
        },
        this);
  }
};

TEST(BoxDistance, LeavesOutOnlyWhatIsAtLeastAsFarAsTheLimit) {
  const std::vector<SampleTree> all = sample_trees(12, 6, 2);
  shapes::Random random(21);
  std::size_t left_out = 0, visits = 0;
  for (int round = 0; round < 1500; ++round) {
    const Scene scene(random, all);
    // The limit is the distance of some pair of triangles, where the bounds are tested most sharply.
    const auto ra = static_cast<std::int32_t>(scene.a.arrays.tree.leaves.size());
    const auto rb = static_cast<std::int32_t>(scene.b.arrays.tree.leaves.size());
    const auto of = [&](std::int32_t i, std::int32_t j) {
      return triangle_distance(scene.triangle(false, i), scene.triangle(true, j));
    };
    const Real limit = of(random.integer(ra), random.integer(rb));
    if (!(limit > 0)) continue;
    Visited visited{static_cast<double>(limit)};
    visited.run(scene);
    std::vector<bool> known(static_cast<std::size_t>(ra) * static_cast<std::size_t>(rb));
    for (const auto& [first_a, count_a, first_b, count_b] : visited.leaves) {
      for (std::int32_t i = first_a; i < first_a + count_a; ++i) {
        for (std::int32_t j = first_b; j < first_b + count_b; ++j) {
          EXPECT_FALSE(known[static_cast<std::size_t>(i * rb + j)]) << "visited twice";
          known[static_cast<std::size_t>(i * rb + j)] = true;
        }
      }
    }
    visits += visited.leaves.size();
    for (int sample = 0; sample < 200; ++sample) {
      const std::int32_t i = random.integer(ra), j = random.integer(rb);
      if (known[static_cast<std::size_t>(i * rb + j)]) continue;
      ++left_out;
      EXPECT_GE(of(i, j), static_cast<Real>(visited.limit) * (1 - 1e-17L)) << round;
    }
  }
  EXPECT_GT(left_out, 50'000U);
  EXPECT_GT(visits, 5'000U);
}

TEST(BoxDistance, BoundsAreTightWhereBodiesAreFarApart) {
  const SampleTree ball(shapes::sphere(4));
  AffineMap map;
  map.offset = Eigen::Vector3d(3e5, 4e5, 1e5);
  const double distance = map.offset.norm() - 2;
  struct Count {
    double limit;
    int visits;
  } count{distance + 1e-3, 0};
  visit_near_leaves(
      ball.arrays.tree, ball.arrays.tree, {{}, ball.body(1), map, ball.body(1), 1e-9}, count.limit,
      [](void* context, std::int32_t, std::int32_t, std::int32_t, std::int32_t) {
        ++static_cast<Count*>(context)->visits;
        return static_cast<Count*>(context)->limit;
      },
      &count);
  EXPECT_GT(count.visits, 0);
  EXPECT_LT(count.visits, 200) << "of some " << 2048 / 3 * 2048 / 3;
}

TEST(BoxDistance, ProvesNothingWithInfiniteOrUnknownNumbers) {
  const SampleTree ball(shapes::sphere(1));
  for (const double bad : {std::numeric_limits<double>::infinity(), std::nan(""), 1e200}) {
    for (int what = 0; what < 2; ++what) {
      AffineMap map;
      (what == 0 ? map.offset[1] : map.linear(0, 2)) = bad;
      int visits = 0;
      visit_near_leaves(
          ball.arrays.tree, ball.arrays.tree, {{}, ball.body(1), map, ball.body(1), 0}, 1e-3,
          [](void* context, std::int32_t, std::int32_t count_a, std::int32_t, std::int32_t count_b) {
            *static_cast<int*>(context) += count_a * count_b;
            return 1e-3;
          },
          &visits);
      EXPECT_EQ(visits, 32 * 32);
    }
  }
}

TEST(BoxDistance, VisitsTheSameLeavesInTheSameOrderOnEveryInstructionSet) {
  const auto sequence = [] {
    shapes::Random random(7);
    const std::vector<SampleTree> all = sample_trees(12, 6, 2);
    std::vector<std::vector<Leaves>> sequences;
    for (int round = 0; round < 200; ++round) {
      const Scene scene(random, all);
      Visited visited{scene.map_b.offset.norm(), scene.map_b.offset.norm() * random(0.2, 1)};
      visited.run(scene);
      sequences.push_back(visited.leaves);
    }
    return sequences;
  };
  EXPECT_GT(expect_same_on_all_targets(sequence).size(), 0U);
}

}  // namespace
}  // namespace encage::test
