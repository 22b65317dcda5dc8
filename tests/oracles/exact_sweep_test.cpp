// SPDX-License-Identifier: GPL-3.0-or-later
// Tests of the oracle: its results for a step are compared with exact tests at single times.
#include "oracles/exact_sweep.h"

#include "oracles/exact_pair.h"
#include "oracles/meshes.h"
#include "oracles/sample_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

MovingMesh random_mesh(std::minstd_rand& random, int triangles, int size) {
  const auto integer = [&](int range) {
    return static_cast<double>(static_cast<int>(random() % (2 * range + 1)) - range);
  };
  MovingMesh mesh;
  mesh.start.resize(4, 3);
  mesh.end.resize(4, 3);
  for (int v = 0; v < 4; ++v) {
    for (int k = 0; k < 3; ++k) mesh.start(v, k) = integer(size), mesh.end(v, k) = integer(size);
  }
  mesh.triangles.resize(triangles, 3);
  for (int t = 0; t < triangles; ++t) mesh.triangles.row(t) << t % 4, (t + 1) % 4, (t + 2) % 4;
  return mesh;
}

bool meet_at(const MovingMesh& a, const MovingMesh& b, double time) {
  const auto corners = [time](const MovingMesh& mesh, std::int64_t t) {
    Corners c;
    for (int k = 0; k < 3; ++k) {
      const auto v = mesh.triangles(t, k);
      c[k] = ((1 - time) * mesh.start.row(v) + time * mesh.end.row(v)).transpose();
    }
    return c;
  };
  for (std::int64_t i = 0; i < a.triangles.rows(); ++i) {
    for (std::int64_t j = 0; j < b.triangles.rows(); ++j) {
      if (triangles_meet(corners(a, i), corners(b, j), 0)) return true;
    }
  }
  return false;
}

TEST(ExactSweep, AgreesWithExactTestsAtSingleTimes) {
  std::minstd_rand random(5);
  int at_start = 0, later = 0, never = 0, seen = 0;
  for (int i = 0; i < 400; ++i) {
    const MovingMesh a = random_mesh(random, 1 + i % 3, 5);
    MovingMesh b = random_mesh(random, 1 + i % 2, 5);
    b.start.col(i % 3).array() += 6;
    const std::optional<TimeBounds> first = exact_first_contact(a, b);
    // Sixteenths of small integers are exact.
    for (int sixteenth = 0; sixteenth <= 16; ++sixteenth) {
      const double time = sixteenth / 16.0;
      if (!meet_at(a, b, time)) continue;
      ASSERT_TRUE(first && first->low <= time) << "pair " << i << " at " << time;
      ++seen;
      break;
    }
    const std::optional<double> close = first_within(a, b, 1e-12, 0, 0x1p-24);
    EXPECT_EQ(first.has_value(), close.has_value()) << "pair " << i;
    EXPECT_EQ(first.has_value(), exact_contact(a, b)) << "pair " << i;
    EXPECT_EQ(close.has_value(), come_within(a, b, 1e-12, 0x1p-24)) << "pair " << i;
    if (first && close) {
      EXPECT_LE(*close, first->high) << "pair " << i;
      EXPECT_NEAR(*close, first->low, 1e-3) << "pair " << i;
    }
    ++(!first ? never : first->high == 0 ? at_start : later);
  }
  EXPECT_GT(at_start, 5);
  EXPECT_GT(later, 50);
  EXPECT_GT(never, 50);
  EXPECT_GT(seen, 30);
}

TEST(ExactSweep, BoxOntoBox) {
  const TriangleMesh box = shapes::box(Vector(0, 0, 0), Vector(1, 1, 1));
  Motion up, down;
  up.end.translation() = Vector(0.25, 0, 1);
  down.start.translation() = Vector(0, 0, 3);
  down.end.translation() = Vector(0, 0, 2);
  // The gap of 2 closes at a rate of 2, so the boxes touch at the end only.
  const MovingMesh a = moving_mesh(Vector::Zero(), box, up), b = moving_mesh(Vector::Zero(), box, down);
  const std::optional<TimeBounds> touch = exact_first_contact(a, b);
  ASSERT_TRUE(touch);
  EXPECT_EQ(touch->high, 1);
  EXPECT_NEAR(touch->low, 1, 1e-15);
  down.end.translation().z() += 1e-9;
  EXPECT_FALSE(exact_first_contact(a, moving_mesh(Vector::Zero(), box, down)));
  // The boxes are half a unit apart at three quarters of the step; with an arc of 1/4 sooner: 2 - 2 t = 1/2 + t (1 -
  // t).
  const std::optional<double> near = first_within(a, b, 0.5, 0, 0x1p-24);
  ASSERT_TRUE(near);
  EXPECT_NEAR(*near, 0.75, 1e-6);
  const std::optional<double> bent = first_within(a, b, 0.5, 0.25, 0x1p-24);
  ASSERT_TRUE(bent);
  EXPECT_NEAR(*bent, (3 - std::sqrt(3.0)) / 2, 1e-6);
  // One box is inside the other: the surfaces do not touch.
  EXPECT_FALSE(
      exact_first_contact(a, moving_mesh(Vector::Zero(), shapes::box(Vector(-9, -9, -9), Vector(9, 9, 9)), {})));
}

}  // namespace
}  // namespace encage::test
