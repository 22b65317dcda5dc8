// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/separation/box_gate.h"

#include "oracles/sample_trees.h"
#include "oracles/sampled.h"
#include "oracles/simd_targets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace encage::test {
namespace {

using Leaves = std::tuple<std::int32_t, std::int32_t, std::int32_t, std::int32_t>;

std::vector<Leaves> visited(const SampleTree& a, const SampleTree& b, const BoxGate& gate) {
  std::vector<Leaves> all;
  visit_leaf_pairs(
      a.arrays.tree, b.arrays.tree, gate,
      [](void* context, std::int32_t first_a, std::int32_t count_a, std::int32_t first_b, std::int32_t count_b) {
        static_cast<std::vector<Leaves>*>(context)->emplace_back(first_a, count_a, first_b, count_b);
        return true;
      },
      &all);
  return all;
}

AffineMap map(const Eigen::Matrix3d& linear, const Eigen::Vector3d& offset) { return {linear, offset}; }

RealTriangle at(const SampleTree& tree, std::int64_t triangle, const std::array<AffineMap, 2>& maps, Real t) {
  RealTriangle result;
  for (int k = 0; k < 3; ++k) {
    const Point x = tree.mesh.corner(triangle, k).cast<Real>();
    const auto position = [&](int end) -> Point {
      return maps[end].linear.cast<Real>() * x + maps[end].offset.cast<Real>();
    };
    result[k] = (1 - t) * position(0) + t * position(1);
  }
  return result;
}

constexpr int samples = 16;

/// Least distance of two triangles over evenly spread times, ends included; any larger value if it exceeds `limit`.
Real least_distance(const SampleTree& a, std::int64_t i, const SampleTree& b, std::int64_t j, const PairMotion& motion,
                    Real limit) {
  Real least = std::numeric_limits<Real>::infinity();
  for (int s = 0; s <= (motion.at_rest ? 0 : samples); ++s) {
    const RealTriangle ta = at(a, i, motion.a, Real(s) / samples), tb = at(b, j, motion.b, Real(s) / samples);
    if (distance_bound(ta, tb) <= limit) least = std::min(least, triangle_distance(ta, tb));
  }
  return least;
}

SampleTree scaled(const SampleTree& tree, double factor) { return SampleTree(shapes::scaled(tree.mesh, factor)); }

/// A step of two bodies whose surfaces pass each other closely, turned by up to 179 degrees.
PairMotion random_step(shapes::Random& random, const SampleTree& a, const SampleTree& b, double size) {
  PairMotion motion;
  const bool rest = random.integer(6) == 0, fast = random.integer(3) == 0;
  const double angle = fast ? 3.12 : 0.3;
  const auto turn = [&] { return random_rotation(random, angle); };
  // Some vertex of a and some vertex of b meet, or almost meet, at a random time.
  const auto vertex = [&](const SampleTree& tree) -> Eigen::Vector3d {
    return tree.mesh.vertex(random.integer(static_cast<int>(tree.mesh.vertices.rows())));
  };
  const Eigen::Vector3d va = vertex(a), vb = vertex(b), way = random.point(fast ? 2 * size : 0.3 * size);
  motion.b[0].linear = random_rotation(random, 3.1);
  motion.a[1].linear = turn();
  motion.b[1].linear = turn() * motion.b[0].linear;
  if (rest) motion.a[1] = motion.a[0];
  if (rest) motion.b[1].linear = motion.b[0].linear;
  const double t = random(0, 1);
  const auto mean = [&](const std::array<AffineMap, 2>& maps, const Eigen::Vector3d& v) -> Eigen::Vector3d {
    return (1 - t) * maps[0](v) + t * maps[1](v);
  };
  const Eigen::Vector3d meet = mean(motion.a, va) - mean(motion.b, vb) + random.point(0.2 * size);
  motion.b[0].offset = meet - (rest ? 0 : t) * way;
  motion.b[1].offset = meet + (rest ? 0 : 1 - t) * way;
  motion.at_rest = rest;
  if (rest) motion.b[1] = motion.b[0];
  if (random.integer(3) != 0) return motion;
  // An interval of the step, in which the maps are not rotations.
  const double t0 = 0.125 * random.integer(7);
  return motion.part(t0, t0 + 0.125 * (1 + random.integer(static_cast<int>((1 - t0) * 8))));
}

TEST(BoxGate, NeverDropsLeavesThatComeNear) {
  const char* rounds = std::getenv("ENCAGE_GATE_ROUNDS");  // for longer manual runs
  shapes::Random random(5);
  const std::vector<SampleTree> all = sample_trees(8, 4, 1);
  std::int64_t visits = 0, dropped = 0;
  for (int round = 0; round < (rounds ? std::atoi(rounds) : 600); ++round) {
    // The sizes range from the smallest to the largest that float32 represents; some are far off the local origins.
    constexpr double factors[] = {1, 1, 1, 1e6, 1e-20, 1e-30, 1e-37, 1e30, 6e37};
    const double factor = factors[random.integer(9)];
    SampleTree a = scaled(all[random.integer(7)], factor), b = scaled(all[random.integer(7)], factor);
    // Some bodies differ in size.
    if (random.integer(4) == 0 && factor < 6e37) b = scaled(b, std::pow(10.0, random(-4, 0)));
    if (random.integer(8) == 0 && factor <= 1) a = scaled(a, std::pow(10.0, random(0, 6)));
    if (factor == 1e6) {
      a = SampleTree(shapes::moved(shapes::scaled(a.mesh, 1e-6), {1e6, -3e5, 2e5}));
      b = SampleTree(shapes::moved(shapes::scaled(b.mesh, 1e-6), {-2e5, 1e6, 8e5}));
    }
    const double size = factor == 1e6 ? 1 : factor;
    const PairMotion motion = random_step(random, a, b, size);
    const auto triangles_a = static_cast<std::int32_t>(a.mesh.triangles.rows());
    const auto triangles_b = static_cast<std::int32_t>(b.mesh.triangles.rows());
    // The limit is the distance of some pair, so this pair barely has to be visited.
    const Real picked = least_distance(a, random.integer(triangles_a), b, random.integer(triangles_b), motion,
                                       std::numeric_limits<Real>::infinity());
    const double distance = random.integer(4) == 0 ? 1e-9 * size : static_cast<double>(picked) * (1 + 1e-12) + 1e-300;
    // The step is one interval, or cut into shorter ones.
    std::set<std::pair<std::int32_t, std::int32_t>> found;
    const int cuts = motion.at_rest ? 1 : std::vector{1, 1, 2, 4}[random.integer(4)];
    for (int cut = 0; cut < cuts; ++cut) {
      const PairMotion part = motion.part(1.0 * cut / cuts, (cut + 1.0) / cuts);
      std::set<std::pair<std::int32_t, std::int32_t>> now;
      for (const auto& [first_a, count_a, first_b, count_b] :
           visited(a, b, {part, a.body(), b.body(), distance, round % 2 == 1})) {
        for (std::int32_t i = first_a; i < first_a + count_a; ++i) {
          for (std::int32_t j = first_b; j < first_b + count_b; ++j) {
            const bool added = now.emplace(a.arrays.tree.leaves[i].triangle, b.arrays.tree.leaves[j].triangle).second;
            EXPECT_TRUE(added) << "visited twice";
          }
        }
      }
      found.merge(now);
    }
    for (std::int32_t i = 0; i < triangles_a; ++i) {
      for (std::int32_t j = 0; j < triangles_b; ++j) {
        if (found.count({i, j}) != 0) continue;
        ++dropped;
        const Real least = least_distance(a, i, b, j, motion, distance);
        ASSERT_GT(least, static_cast<Real>(distance) * (1 - 1e-15L))
            << "round " << round << ", factor " << factor << ", triangles " << i << " and " << j;
      }
    }
    visits += std::ssize(found);
  }
  RecordProperty("visits", static_cast<int>(visits));
  RecordProperty("dropped", static_cast<int>(dropped));
  EXPECT_GT(visits, 10'000);
  EXPECT_GT(dropped, 10'000);
}

TEST(BoxGate, VisitsFewLeavesThatAreFarApart) {
  shapes::Random random(6);
  const SampleTree a(shapes::sphere(3)), b(shapes::torus(1, 0.3, 40, 20));
  std::size_t visits = 0, near_visits = 0, pairs = 0;
  for (int round = 0; round < 60; ++round) {
    PairMotion motion;
    motion.a[1].linear = random_rotation(random, 0.1);
    motion.b[0] = map(random_rotation(random, 3.1), random_direction(random) * random(1.6, 2.2));
    motion.b[1] = map(random_rotation(random, 0.1) * motion.b[0].linear, motion.b[0].offset + random.point(0.1));
    const double distance = 0.01;
    for (const auto& [first_a, count_a, first_b, count_b] :
         visited(a, b, BoxGate(motion, a.body(), b.body(), distance))) {
      ++visits;
      // The leaves are about 0.2 wide and move by as much.
      Real least = 1;
      for (std::int32_t i = first_a; i < first_a + count_a; ++i) {
        for (std::int32_t j = first_b; j < first_b + count_b; ++j) {
          for (int s = 0; s <= 4; ++s) {
            least = std::min(least, triangle_distance(at(a, a.arrays.tree.leaves[i].triangle, motion.a, Real(s) / 4),
                                                      at(b, b.arrays.tree.leaves[j].triangle, motion.b, Real(s) / 4)));
          }
        }
      }
      near_visits += least < 0.25L;
    }
    pairs += a.arrays.tree.leaves.size() * b.arrays.tree.leaves.size();
  }
  EXPECT_GT(visits, 100U);
  EXPECT_LT(visits * 100, pairs);
  EXPECT_GE(near_visits * 100, visits * 95);
}

// The spheres are apart by more than the distance, but along no axis of theirs.
TEST(BoxGate, DirectionsSeparateSmallBoxesAtLargeDistances) {
  const SampleTree a(shapes::sphere(4));
  std::size_t without = 0, with = 0;
  for (const bool rest : {false, true}) {
    PairMotion motion;
    motion.at_rest = rest;
    motion.b[0].offset = motion.b[1].offset = Eigen::Vector3d(1.7, 1.7, 1.7);
    if (!rest) motion.b[1].offset.x() += 0.01;
    without += visited(a, a, BoxGate(motion, a.body(), a.body(), 0.93)).size();
    with += visited(a, a, BoxGate(motion, a.body(), a.body(), 0.93, true)).size();
    EXPECT_FALSE(visited(a, a, BoxGate(motion, a.body(), a.body(), 0.96, true)).empty());
  }
  EXPECT_GT(without, 50U);
  EXPECT_EQ(with, 0U);
}

TEST(BoxGate, TakesOneStepForEachPairOfBoxes) {
  const SampleTree a(shapes::sphere(3));
  PairMotion motion;
  motion.at_rest = true;
  const BoxGate gate(motion, a.body(), a.body(), 1e-3);
  const auto visits = [&](std::int64_t steps, std::int64_t& left) {
    std::int64_t count = 0;
    left = steps;
    visit_leaf_pairs(
        a.arrays.tree, a.arrays.tree, gate,
        [](void* c, std::int32_t, std::int32_t, std::int32_t, std::int32_t) {
          ++*static_cast<std::int64_t*>(c);
          return true;
        },
        &count, &left);
    return count;
  };
  constexpr std::int64_t plenty = 1'000'000;
  std::int64_t left = 0;
  const std::int64_t all = visits(plenty, left), taken = plenty - left;
  EXPECT_GT(taken, all);
  EXPECT_EQ(visits(taken, left), all);
  EXPECT_EQ(left, 0);
  EXPECT_LT(visits(taken / 2, left), all);
  EXPECT_LT(left, 0);
  EXPECT_GE(left, -4);  // four tests run together
}

// Two sheets are parallel but askew to all axes, and apart by a hundredth of their size: boxes overlap down to the
// leaves.
TEST(BoxGate, SlabsSeparateSheetsWhoseBoxesOverlap) {
  shapes::Random random(8);
  TriangleMesh sheet;
  sheet.vertices.resize(21 * 21, 3);
  sheet.triangles.resize(20 * 20 * 2, 3);
  for (int i = 0; i < 21; ++i) {
    for (int j = 0; j < 21; ++j) sheet.vertices.row(21 * i + j) << 0.05 * i - 0.5, 0.05 * j - 0.5, 0;
  }
  for (int i = 0, t = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      const int v = 21 * i + j;
      sheet.triangles.row(t++) << v, v + 21, v + 1;
      sheet.triangles.row(t++) << v + 1, v + 21, v + 22;
    }
  }
  for (int round = 0; round < 50; ++round) {
    const Eigen::Matrix3d tilt = random_rotation(random, 3.1), turn = random_rotation(random, 3.1);
    const auto turned = [&](const Eigen::Matrix3d& rotation) {
      TriangleMesh mesh = sheet;
      mesh.vertices = (sheet.vertices * rotation.transpose()).eval();
      mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
      return SampleTree(mesh);
    };
    // Both sheets are in one plane, each in a frame of its own; then b is lifted off it.
    const SampleTree a = turned(tilt), b = turned(turn);
    PairMotion motion;
    motion.b[0] = map(tilt * turn.transpose(), tilt.col(2) * 0.01);
    motion.b[1] = map(motion.b[0].linear, tilt.col(2) * 0.02 + tilt.col(0) * 0.1);
    EXPECT_TRUE(visited(a, b, BoxGate(motion, a.body(), b.body(), 0.005)).empty());
    motion.at_rest = true;
    motion.b[1] = motion.b[0];
    EXPECT_TRUE(visited(a, b, BoxGate(motion, a.body(), b.body(), 0.005)).empty());
    EXPECT_FALSE(visited(a, b, BoxGate(motion, a.body(), b.body(), 0.015)).empty());
  }
}

TEST(BoxGate, StopsWhenAskedTo) {
  const SampleTree a(shapes::sphere(2));
  PairMotion motion;
  motion.at_rest = true;
  const BoxGate gate(motion, a.body(), a.body(), 1e-3);
  const std::size_t all = visited(a, a, gate).size();
  ASSERT_GT(all, 50U);
  for (const int stop_after : {1, 7}) {
    int left = stop_after, calls = 0;
    std::pair<int*, int*> context{&left, &calls};
    const bool finished = visit_leaf_pairs(
        a.arrays.tree, a.arrays.tree, gate,
        [](void* c, std::int32_t, std::int32_t, std::int32_t, std::int32_t) {
          const auto& [remaining, count] = *static_cast<std::pair<int*, int*>*>(c);
          ++*count;
          return --*remaining > 0;
        },
        &context);
    EXPECT_FALSE(finished);
    EXPECT_EQ(calls, stop_after);
  }
}

TEST(BoxGate, ProvesNothingWithInfiniteOrUnknownNumbers) {
  const SampleTree a(shapes::sphere(1));
  const std::size_t all = a.arrays.tree.leaves.size() * a.arrays.tree.leaves.size();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const auto pairs = [&](const PairMotion& motion, double distance) {
    std::size_t sum = 0;
    for (const auto& [first_a, count_a, first_b, count_b] :
         visited(a, a, BoxGate(motion, a.body(), a.body(), distance))) {
      sum += static_cast<std::size_t>(count_a) * static_cast<std::size_t>(count_b);
    }
    return sum;
  };
  for (const bool rest : {false, true}) {
    PairMotion motion;
    motion.at_rest = rest;
    motion.b[0].offset = motion.b[1].offset = Eigen::Vector3d(10, 0, 0);
    EXPECT_EQ(pairs(motion, 1), 0U);
    EXPECT_EQ(pairs(motion, infinity), all);
    EXPECT_EQ(pairs(motion, nan), all);
    EXPECT_EQ(pairs(motion, 1e300), all);
    for (const double bad : {nan, infinity, -infinity}) {
      PairMotion spoiled = motion;
      spoiled.b[0].offset.x() = bad;
      EXPECT_EQ(pairs(spoiled, 1), all) << bad;
      spoiled = motion;
      spoiled.b[0].linear.setConstant(bad);
      EXPECT_EQ(pairs(spoiled, 1), all) << bad;
    }
  }
}

TEST(BoxGate, VisitsTheSameLeavesInTheSameOrderOnEveryInstructionSet) {
  const auto sequence = [] {
    shapes::Random random(7);
    const std::vector<SampleTree> all = sample_trees(8, 4, 1);
    std::vector<std::vector<Leaves>> sequences;
    for (int round = 0; round < 300; ++round) {
      const SampleTree &a = all[random.integer(7)], &b = all[random.integer(7)];
      const PairMotion motion = random_step(random, a, b, 1);
      sequences.push_back(visited(a, b, BoxGate(motion, a.body(), b.body(), random(0, 0.2), round % 2 == 1)));
    }
    return sequences;
  };
  EXPECT_GT(expect_same_on_all_targets(sequence).size(), 0U);
}

}  // namespace
}  // namespace encage::test
