// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/contact/contact_solver.h"

#include "tests/cagegen/contact/shapes.h"

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

namespace encage::makers {
namespace {

using shapes::Nested;
using shapes::Random;
using Positions = ContactSolver::Positions;

/// Of all sizes: trembling, shrinking, mirrored, scattered, one vertex only.
Positions random_places(Random& random, const Positions& positions, double size) {
  Positions wanted = positions;
  const int kind = random.integer(6);
  const Point shift = random.point(size);
  const double factor = random(-1.5, 1.5);
  for (Point& p : wanted) {
    if (kind == 0) p += shift;
    if (kind == 1) p *= factor;
    if (kind == 2) p = shift;
    if (kind >= 3 && kind < 5) p += random.point(size);
    if (kind == 4 && random.integer(3) > 0) p = positions[&p - wanted.data()];
  }
  if (kind == 5) wanted[random.integer(static_cast<int>(wanted.size()))] += random.point(size);
  return wanted;
}

/// Returns how many steps led elsewhere.
int expect_valid_walk(const Nested& scene, double size, std::uint32_t seed, int steps = 12) {
  constexpr double self_clearance = 2e-3;
  SCOPED_TRACE(scene.name + ", size " + std::to_string(size));
  Random random(seed);
  const Obstacle obstacle(scene.inner);
  ContactSolver solver(scene.cage, shapes::contact_options(1, self_clearance));
  int moved = 0;
  for (int step = 0; step < steps; ++step) {
    const TriangleMesh before = solver.mesh();
    const Positions next = solver.approach(obstacle, random_places(random, solver.positions(), size));
    EXPECT_EQ(solver.positions(), shapes::positions(before)) << "not before commit()";
    const TriangleMesh after = shapes::at(scene.cage, next);
    shapes::expect_all_apart(scene.inner, after, before, self_clearance);
    // A surface may have been passed as a whole: that is encloses_all()'s to say.
    if (!solver.encloses_all(obstacle, next)) continue;
    shapes::expect_certified(scene.inner, after);
    if (testing::Test::HasFailure()) return moved;
    moved += next != solver.positions();
    // One not taken in between must leave no trace.
    if (random.integer(3) > 0) solver.commit(next);
  }
  return moved;
}

TEST(Approach, EndsInAStateThatTheCertificateAccepts) {
  for (const Nested& scene : shapes::nested()) {
    shapes::expect_certified(scene.inner, scene.cage);
    std::uint32_t seed = 0;
    for (const double size : {1e-4, 1e-2, 0.1, 0.4, 2.0}) {
      EXPECT_GT(expect_valid_walk(scene, size, ++seed), size > 0.3 ? 0 : 4);
      if (HasFailure()) return;
    }
  }
}

TEST(Approach, ExtremePlaces) {
  for (const Nested& scene : shapes::nested()) {
    for (const double size : {1e3, 1e18, 1e38, 1e200}) {
      expect_valid_walk(scene, size, 7, 6);
      if (HasFailure()) return;
    }
  }
}

TEST(Approach, NoNumberLeavesAVertexWhereItIs) {
  const Nested scene = shapes::nested()[0];
  const Obstacle obstacle(scene.inner);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    ContactSolver solver(scene.cage, shapes::contact_options());
    Positions wanted = solver.positions();
    for (Point& p : wanted) p *= 0.9;
    wanted[5].y() = bad;
    const Positions next = solver.approach(obstacle, wanted);
    EXPECT_EQ(next[5], solver.positions()[5]);
    EXPECT_NE(next, solver.positions()) << "others go on";
    shapes::expect_certified(scene.inner, shapes::at(scene.cage, next));
  }
}

TEST(Approach, WhatIsFreeIsReached) {
  const Nested scene = shapes::nested()[0];
  const Obstacle obstacle(scene.inner);
  ContactSolver solver(scene.cage, shapes::contact_options());
  const Positions wanted = shapes::positions(shapes::rounded(shapes::scaled(scene.cage, 1.3)));
  EXPECT_EQ(solver.approach(obstacle, wanted), wanted);
  EXPECT_EQ(solver.approach(obstacle, solver.positions()), solver.positions());
}

TEST(Approach, StopsAtTheObstacle) {
  // A cube drawn onto a smaller one comes as near as contacts ask for: 1.6 clearances.
  const TriangleMesh inner = shapes::cube(0.5);
  ContactSolver solver(shapes::cube(1), shapes::contact_options());
  const Obstacle obstacle(inner);
  solver.commit(solver.approach(obstacle, shapes::positions(shapes::cube(0.5))));
  shapes::expect_certified(inner, solver.mesh());
  for (const Point& p : solver.positions()) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::abs(p[k]), 0.5 + 1.6 * shapes::test_clearance, shapes::test_clearance);
  }
}

TEST(Approach, AComponentIsNotPassed) {
  // A small tetrahedron beside the main body; the cage's corner is drawn over it.
  const TriangleMesh inner = shapes::joined(shapes::cube(0.3), shapes::tetrahedron(0.02, {0.9, 0.9, 0.9}));
  const TriangleMesh cage = shapes::cube(1);
  const Obstacle obstacle(inner);
  ContactSolver solver(cage, shapes::contact_options());
  Positions wanted = solver.positions();
  for (Point& p : wanted) p *= 0.7;
  const Positions jumped = wanted;
  EXPECT_FALSE(solver.encloses_all(obstacle, jumped));
  EXPECT_TRUE(solver.encloses_all(obstacle, solver.positions()));
  EXPECT_FALSE(certify(inner, Solid::closed, shapes::at(cage, jumped)).holds);
}

TEST(Approach, AComponentOfTheCageDoesNotSwallowAnother) {
  const TriangleMesh inner = shapes::joined(shapes::cube(0.5), shapes::cube(0.1, {2, 0, 0}));
  const TriangleMesh cage = shapes::joined(shapes::cube(1), shapes::cube(0.25, {2, 0, 0}));
  const Obstacle obstacle(inner);
  const ContactSolver start(cage, shapes::contact_options());
  Positions wanted = start.positions();
  for (std::size_t v = 0; v < 8; ++v) {
    if (wanted[v].x() > 0) wanted[v].x() = 3;
  }
  ContactSolver solver = start;
  const Positions next = solver.approach(obstacle, wanted);
  EXPECT_EQ(next, wanted) << "nothing touches";
  EXPECT_FALSE(certify(inner, Solid::closed, shapes::at(cage, next)).holds);
  EXPECT_FALSE(solver.encloses_all(obstacle, next));
  EXPECT_TRUE(solver.encloses(next, {0, 0, 0}));
  EXPECT_FALSE(solver.encloses(next, {2, 0, 0}));
  EXPECT_FALSE(solver.encloses(next, {9, 0, 0}));
}

TEST(Approach, AStateNotTakenLeavesNoTrace) {
  // The second cube goes away, which is not committed; then the first one is moved to where it still is.
  const TriangleMesh inner = shapes::joined(shapes::cube(0.1), shapes::cube(0.1, {3, 0, 0}));
  const TriangleMesh cage = shapes::joined(shapes::cube(0.5), shapes::cube(0.5, {3, 0, 0}));
  const Obstacle obstacle(inner);
  ContactSolver solver(cage, shapes::contact_options());
  Positions away = solver.positions();
  for (std::size_t v = 8; v < 16; ++v) away[v].x() += away[v].x() > 3 ? 6 : 5.5;
  solver.approach(obstacle, away);
  Positions into = solver.positions();
  for (std::size_t v = 0; v < 8; ++v) {
    if (into[v].x() > 0) into[v].x() = 2.75;
  }
  const Positions next = solver.approach(obstacle, into);
  shapes::expect_certified(inner, shapes::at(cage, next));
}

TEST(Approach, AVertexKeepsItsConeAlsoWhereAFaceRests) {
  // A pyramid over a convex hexagon, whose two last corners are drawn in until the hexagon is seen whole from no point:
  // the tip would lose its cone, though some of its faces never move.
  const auto pyramid = [](double in) {
    return shapes::mesh(
        {{3, 3, 4},
         {0, 0, 0},
         {6, 0, 0},
         {6, 5, 0},
         {4 + 1.5 * in, 6 - 5 * in, 0},
         {2 - 1.5 * in, 6 - 5 * in, 0},
         {0, 5, 0}},
        {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 6}, {0, 6, 1}, {1, 6, 5}, {1, 5, 4}, {1, 4, 2}, {2, 4, 3}});
  };
  const TriangleMesh cage = pyramid(0);
  const TriangleMesh folded = pyramid(1);
  const TriangleMesh inner = shapes::tetrahedron(0.05, {3, 0.3, 0.1});
  shapes::expect_certified(inner, cage);
  shapes::expect_certified(inner, folded);
  std::vector<Point> normals;
  for (std::int64_t t = 0; t < 6; ++t) normals.push_back(Prism(shapes::corners(folded, t)).normal);
  ASSERT_FALSE(common_direction(normals));
  ContactSolver solver(cage, shapes::contact_options());
  EXPECT_EQ(solver.approach(Obstacle(inner), shapes::positions(folded)), solver.positions());
  // Less of it is allowed.
  const TriangleMesh bent = shapes::rounded(pyramid(0.3));
  EXPECT_EQ(solver.approach(Obstacle(inner), shapes::positions(bent)), shapes::positions(bent));
}

TEST(Approach, TheSameForAnyNumberOfThreads) {
  const TriangleMesh inner = shapes::scaled(shapes::torus(1, 0.3, 40, 20), 0.97);
  const TriangleMesh cage = shapes::rounded(shapes::torus(1, 0.4, 36, 18));
  const Obstacle obstacle(inner);
  std::vector<Positions> first;
  for (const int threads : {1, 2, 3}) {
    Random random(11);
    ContactSolver solver(cage, shapes::contact_options(threads));
    std::vector<Positions> path;
    for (int step = 0; step < 5; ++step) {
      Positions wanted = solver.positions();
      for (Point& p : wanted) p = 0.97 * p + random.point(0.05);
      solver.commit(solver.approach(obstacle, wanted));
      path.push_back(solver.positions());
    }
    if (first.empty()) first = path;
    EXPECT_EQ(path, first);
  }
}

TEST(Approach, CheckMayStopIt) {
  const Nested scene = shapes::nested()[0];
  ContactSolverOptions options = shapes::contact_options();
  options.check = [] { throw std::runtime_error("stop"); };
  ContactSolver solver(scene.cage, options);
  EXPECT_THROW(solver.approach(Obstacle(scene.inner), solver.positions()), std::runtime_error);
}

TEST(ContactSolver, WorkGrows) {
  const Nested scene = shapes::nested()[0];
  const Obstacle obstacle(scene.inner);
  ContactSolver solver(scene.cage, shapes::contact_options());
  EXPECT_EQ(solver.work(), 0);
  const auto faces = static_cast<std::int64_t>(solver.face_count());
  ASSERT_EQ(faces, scene.cage.triangles.rows());
  solver.approach(obstacle, solver.positions());
  EXPECT_EQ(solver.work(), 0) << "nothing moves";
  Positions wanted = solver.positions();
  for (Point& p : wanted) p *= 1.1;
  solver.approach(obstacle, wanted);
  EXPECT_EQ(solver.work(), faces);
}

TEST(ContactSolver, KeepsTheMesh) {
  const TriangleMesh cage = shapes::nested()[1].cage;
  const ContactSolver solver(cage, shapes::contact_options());
  EXPECT_EQ(solver.mesh().vertices, cage.vertices);
  EXPECT_EQ(solver.mesh().triangles, cage.triangles);
}

TEST(Approach, HeavierVerticesComeNearerToWhereTheyWant) {
  const Nested scene{"", shapes::sphere(2), shapes::cube(1.5)};
  const Obstacle obstacle(scene.inner);
  Positions wanted = shapes::positions(scene.cage);
  for (Point& p : wanted) p *= 0.5;
  const auto misses = [&](const std::vector<double>& weights) {
    ContactSolver solver(scene.cage, shapes::contact_options(1, 2e-3));
    const Positions reached = solver.approach(obstacle, wanted, weights);
    shapes::expect_certified(scene.inner, shapes::at(scene.cage, reached));
    return (reached[0] - wanted[0]).norm();
  };
  const double alone = misses({});
  EXPECT_EQ(misses(std::vector<double>(8, 1.0)), alone);
  std::vector<double> weights(8, 1.0);
  weights[0] = 20;
  EXPECT_LT(misses(weights), 0.8 * alone);
}

}  // namespace
}  // namespace encage::makers
