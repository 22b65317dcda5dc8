// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/contact/contact_solver.h"
#include "tests/cagegen/contact/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace encage::makers {
namespace {

using shapes::Random;
using Positions = ContactSolver::Positions;

constexpr double step_reach = 40 * shapes::test_clearance;

/// Moves `inner` from where the cage is valid to `target` in equal steps; expects every accepted state to be proven.
/// Returns the steps taken before one had no solution.
int follow_all(ContactSolver& solver, const TriangleMesh& inner, const Vertices& target, int steps, double reach) {
  Obstacle before(inner);
  Obstacle after(inner);
  TriangleMesh place = inner;
  for (int step = 1; step <= steps; ++step) {
    place.vertices = inner.vertices + (target - inner.vertices) * (static_cast<double>(step) / steps);
    after.move(place.vertices);
    const TriangleMesh start = solver.mesh();
    const auto next = solver.follow(before, after, solver.positions(), reach);
    EXPECT_EQ(solver.positions(), shapes::positions(start)) << "not before commit()";
    if (!next) return step - 1;
    const TriangleMesh cage = shapes::at(start, *next);
    shapes::expect_all_apart(place, cage, start, solver.options().self_clearance);
    if (!solver.encloses_all(after, *next)) return step - 1;
    shapes::expect_certified(place, cage);
    solver.commit(*next);
    std::swap(before, after);
  }
  return steps;
}

TEST(Follow, AGrowingSphereWidensItsCage) {
  const TriangleMesh inner = shapes::scaled(shapes::sphere(2), 0.7);
  const TriangleMesh cage = shapes::rounded(shapes::sphere(1));
  for (const double reach : {0.0, step_reach}) {
    ContactSolver solver(cage, shapes::contact_options());
    ASSERT_EQ(follow_all(solver, inner, Vertices(1.6 * inner.vertices), reach > 0 ? 20 : 4, reach), reach > 0 ? 20 : 4);
    for (const Point& p : solver.positions()) EXPECT_GT(p.norm(), 1.12);
    EXPECT_LT(signed_volume(solver.mesh()), 8 * 1.6);
  }
}

TEST(Follow, WhatIsNotMetDoesNotMove) {
  const TriangleMesh inner = shapes::scaled(shapes::sphere(2), 0.3);
  ContactSolver solver(shapes::rounded(shapes::sphere(2)), shapes::contact_options());
  const Positions start = solver.positions();
  const Vertices grown = 2 * inner.vertices;
  EXPECT_EQ(follow_all(solver, inner, grown, 3, 0), 3);
  EXPECT_EQ(solver.positions(), start);
}

TEST(Follow, ASpikePushesAndDoesNotTunnel) {
  // One vertex of the inner sphere goes out through the middle of a face of a coarse cage.
  TriangleMesh inner = shapes::scaled(shapes::sphere(3), 0.5);
  const Point direction = Point(1, 1, 1).normalized();
  Eigen::Index tip = 0;
  (inner.vertices * direction).maxCoeff(&tip);
  Vertices target = inner.vertices;
  target.row(tip) = 2.5 * direction.transpose();
  for (const int steps : {1, 3, 10}) {
    ContactSolver solver(shapes::rounded(shapes::sphere(0)), shapes::contact_options());
    const int taken = follow_all(solver, inner, target, steps, 0);
    ASSERT_TRUE(taken == steps || steps == 1);
    if (taken < steps) continue;
    double highest = 0;
    for (const Point& p : solver.positions()) highest = std::max(highest, p.dot(direction));
    EXPECT_GT(highest, 2.5);
  }
}

TEST(Follow, AComponentThatJumpsOutIsNoticed) {
  // The second component leaves the cage in one step, touching nothing where it arrives.
  const TriangleMesh small = shapes::tetrahedron(0.05, {0.5, 0, 0});
  const TriangleMesh inner = shapes::joined(shapes::cube(0.2), small);
  Vertices target = inner.vertices;
  target.bottomRows(4).col(0).array() += 2;
  const Obstacle before(inner);
  TriangleMesh gone = inner;
  gone.vertices = target;
  const Obstacle after(gone);
  ContactSolver solver(shapes::cube(1), shapes::contact_options());
  const auto next = solver.follow(before, after, solver.positions());
  ASSERT_TRUE(next);
  EXPECT_FALSE(certify(gone, Solid::closed, shapes::at(solver.mesh(), *next)).holds);
}

TEST(Follow, ShortStepsDoNotLetAComponentJump) {
  const TriangleMesh inner = shapes::joined(shapes::cube(0.2), shapes::tetrahedron(0.1, {0.5, 0, 0}));
  Vertices target = inner.vertices;
  target.bottomRows(4).col(0).array() += 1;
  ContactSolver solver(shapes::rounded(shapes::sphere(2)), shapes::contact_options());
  EXPECT_EQ(follow_all(solver, inner, target, 20, 0), 20);
}

/// Two plates far apart, each moving onto the cage's wall between them: the inner sides of a cage of the shape of a U,
/// whose strands have no room in the end.
struct Pinch {
  TriangleMesh inner;
  TriangleMesh cage;
  Vertices target;
};

Pinch pinch() {
  // Two boxes side by side as two components, both caged; they end 1.5 clearances from each other.
  Pinch p;
  const Point shift(1.2, 0, 0);
  p.inner = shapes::joined(shapes::cube(0.5), shapes::cube(0.5, shift));
  p.cage = shapes::rounded(shapes::joined(shapes::cube(0.54), shapes::cube(0.54, shift)));
  p.target = p.inner.vertices;
  p.target.bottomRows(8).col(0).array() -= 0.2 - 1.5 * shapes::test_clearance;
  return p;
}

TEST(Follow, APinchHasNoSolutionAndIsNamed) {
  const Pinch p = pinch();
  for (const double reach : {0.0, step_reach}) {
    for (const int steps : {1, 4, 40}) {
      ContactSolver solver(p.cage, shapes::contact_options());
      const int taken = follow_all(solver, p.inner, p.target, steps, reach);
      EXPECT_LT(taken, steps);
      ASSERT_FALSE(solver.jammed().empty());
      EXPECT_TRUE(std::is_sorted(solver.jammed().begin(), solver.jammed().end()));
      EXPECT_EQ(std::adjacent_find(solver.jammed().begin(), solver.jammed().end()), solver.jammed().end());
      // A face between the two is among them.
      const TriangleMesh cage = solver.mesh();
      EXPECT_TRUE(std::any_of(solver.jammed().begin(), solver.jammed().end(), [&](std::int32_t f) {
        return std::abs((cage.corner(f, 0).x() + cage.corner(f, 1).x() + cage.corner(f, 2).x()) / 3 - 0.55) < 0.2;
      }));
    }
  }
}

TEST(Follow, RoomForBothStrandsIsFound) {
  Pinch p = pinch();
  // 8 clearances from each other, of which the contacts ask for 3 x 1.6.
  p.target = p.inner.vertices;
  p.target.bottomRows(8).col(0).array() -= 0.2 - 8 * shapes::test_clearance;
  ContactSolver solver(p.cage, shapes::contact_options());
  EXPECT_EQ(follow_all(solver, p.inner, p.target, 10, 0), 10);
}

TEST(Follow, RandomMotions) {
  int total = 0;
  for (const shapes::Nested& scene : shapes::nested()) {
    SCOPED_TRACE(scene.name);
    for (std::uint32_t seed = 1; seed <= 6; ++seed) {
      Random random(seed);
      ContactSolver solver(scene.cage, shapes::contact_options());
      Vertices target = scene.inner.vertices;
      const double size = seed % 2 ? 0.02 : 0.15;
      for (std::int64_t v = 0; v < target.rows(); ++v) target.row(v) += random.point(size).transpose();
      total += follow_all(solver, scene.inner, target, 4, seed % 3 == 0 ? step_reach : 0);
      if (HasFailure()) return;
    }
  }
  EXPECT_GT(total, 60);
}

TEST(Follow, TheSameForAnyNumberOfThreads) {
  const TriangleMesh inner = shapes::torus(1, 0.2, 30, 16);
  const TriangleMesh cage = shapes::rounded(shapes::torus(1, 0.3, 24, 14));
  Vertices target = inner.vertices;
  target.col(2) *= 1.8;
  for (const double reach : {0.0, step_reach}) {
    Positions first;
    for (const int threads : {1, 2, 3}) {
      ContactSolver solver(cage, shapes::contact_options(threads));
      EXPECT_EQ(follow_all(solver, inner, target, 4, reach), 4);
      if (first.empty()) first = solver.positions();
      EXPECT_EQ(solver.positions(), first);
    }
  }
}

}  // namespace
}  // namespace encage::makers
