// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/contact/minimize.h"

#include "cagegen/collapse/collapse.h"
#include "cagegen/collapse/starts.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace encage::makers {
namespace {

constexpr double test_clearance = 1e-4;

ContactSolverOptions options(
    int threads, std::function<void()> check = [] {}) {
  return {test_clearance, test_clearance, threads, std::move(check)};
}

void expect_shrinks(const TriangleMesh& solid, const TriangleMesh& cage, double most) {
  const Obstacle obstacle(solid);
  ASSERT_TRUE(clear(obstacle, cage, test_clearance));
  const auto work_of = [&](int threads, TriangleMesh& result) {
    const std::uint64_t before = Obstacle::work();
    result = shrink(obstacle, cage, options(threads));
    return Obstacle::work() - before;
  };
  TriangleMesh first;
  const std::uint64_t work = work_of(1, first);
  const CertifyResult proof = certify(solid, Solid::closed, first);
  ASSERT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, 0.999 * test_clearance);
  EXPECT_LE(signed_volume(first), signed_volume(cage));
  EXPECT_LE(signed_volume(first), most);
  EXPECT_EQ(first.triangles, cage.triangles);
  EXPECT_EQ(first.vertices, shapes::rounded(first).vertices);
  // Budgets of work end at the same place, too.
  for (const int threads : {2, 3}) {
    TriangleMesh again;
    EXPECT_EQ(work_of(threads, again), work);
    EXPECT_EQ(again.vertices, first.vertices);
  }
}

TriangleMesh inflated(const TriangleMesh& solid, double height) {
  const auto cage = offset_start(Obstacle(solid), solid, height, false, test_clearance);
  EXPECT_TRUE(cage);
  return cage.value_or(solid);
}

TEST(Shrink, ComesBackToTheSurface) {
  const TriangleMesh sphere = shapes::sphere(3);
  expect_shrinks(sphere, inflated(sphere, 0.05), 1.02 * signed_volume(sphere));
  const TriangleMesh torus = shapes::torus(1, 0.3, 24, 12);
  expect_shrinks(torus, inflated(torus, 0.05), 1.1 * signed_volume(torus));
}

TEST(Shrink, CoarseCages) {
  const TriangleMesh torus = shapes::torus(1, 0.35, 40, 20);
  const Obstacle obstacle(torus);
  EditorOptions options;
  options.clearance = options.self_clearance = test_clearance;
  CageEditor editor(obstacle, inflated(torus, 0.01), options);
  CollapseLimits limits;
  limits.faces = 320;
  ASSERT_TRUE(collapse_edges(editor, limits));
  const TriangleMesh cage = editor.extract();
  expect_shrinks(torus, cage, signed_volume(cage) * 0.9999);
}

TEST(Shrink, PartsOfTheCageKeepTheirDistance) {
  // Two cubes side by side, their cages nearly touching; and one cage through which a hole is left.
  const TriangleMesh solid = shapes::joined(shapes::cube(1), shapes::cube(1, {2.5, 0, 0}));
  const TriangleMesh cage = shapes::rounded(shapes::joined(shapes::cube(1.24), shapes::cube(1.24, {2.5, 0, 0})));
  expect_shrinks(solid, cage, 1.1 * signed_volume(solid));
}

TEST(Shrink, CheckMayStopIt) {
  const TriangleMesh sphere = shapes::sphere(2);
  const TriangleMesh cage = inflated(sphere, 0.05);
  const auto stop = [] { throw std::runtime_error("stop"); };
  EXPECT_THROW(shrink(Obstacle(sphere), cage, options(2, stop)), std::runtime_error);
}

/// Draws the cage to a position of its own in one direction: nothing that the built-in energies do.
class Sideways final : public CageEnergy {
  std::string name() const override { return "sideways"; }
  double value(const EnergyState& state) const override { return state.cage.col(0).sum(); }
  Vertices gradient(const EnergyState& state) const override {
    Vertices result = Vertices::Zero(state.cage.rows(), 3);
    result.col(0).setOnes();
    return result;
  }
};

struct Minimized {
  double before;
  double after;
  TriangleMesh cage;
  std::int64_t work;
};

Minimized minimized(const TriangleMesh& solid, const TriangleMesh& rest, const TriangleMesh& cage,
                    const CageEnergy& energy, MinimizeRequest request = {}) {
  ContactSolver solver(cage, options(1));
  request.fine = &solid;
  request.rest = &rest;
  request.energy = &energy;
  minimize(solver, Obstacle(solid), request);
  const TriangleMesh result = solver.mesh();
  return {energy.value({solid, rest, cage.vertices, cage.vertices}),
          energy.value({solid, rest, cage.vertices, result.vertices}), result, solver.work()};
}

TEST(Minimize, NeverRaisesTheEnergy) {
  shapes::Random random(8);
  const Sideways sideways;
  const EnergyPtr start = start_energy(), step = step_energy(), volume = volume_energy();
  for (const TriangleMesh& solid : {shapes::sphere(2), shapes::torus(1, 0.3, 20, 10)}) {
    for (int round = 0; round < 4; ++round) {
      const TriangleMesh cage = inflated(solid, random(0.02, 0.1));
      // The energy's rest cuts through the solid.
      TriangleMesh rest = cage;
      for (std::int64_t v = 0; v < rest.vertices.rows(); ++v) rest.vertices.row(v) += random.point(0.1).transpose();
      for (const CageEnergy* energy :
           {start.get(), step.get(), volume.get(), static_cast<const CageEnergy*>(&sideways)}) {
        SCOPED_TRACE(energy->name());
        const Minimized result = minimized(solid, rest, cage, *energy);
        if (energy->name() == "step") {
          EXPECT_EQ(result.cage.vertices, cage.vertices) << "at its minimum";
        } else {
          EXPECT_LT(result.after, result.before);
        }
        const CertifyResult proof = certify(solid, Solid::closed, result.cage);
        EXPECT_TRUE(proof.holds) << proof.reason;
      }
    }
  }
}

TEST(Minimize, ReachesAFreeMinimum) {
  const TriangleMesh solid = shapes::scaled(shapes::sphere(2), 0.5);
  const TriangleMesh rest = shapes::rounded(shapes::sphere(1));
  const Minimized result = minimized(solid, rest, shapes::rounded(shapes::scaled(rest, 1.4)), *start_energy());
  EXPECT_LT(result.after, 1e-4 * result.before);
}

TEST(Minimize, KeepsToItsBudget) {
  const TriangleMesh solid = shapes::sphere(3);
  const TriangleMesh cage = inflated(solid, 0.1);
  const EnergyPtr volume = volume_energy();
  MinimizeRequest request;
  request.enough = 0;
  const Minimized all = minimized(solid, cage, cage, *volume, request);
  request.face_tests = all.work / 4;
  const Minimized part = minimized(solid, cage, cage, *volume, request);
  EXPECT_LT(part.work, all.work);
  EXPECT_GT(part.after, all.after);
  EXPECT_LT(part.after, part.before);
  request.iterations = 0;
  EXPECT_EQ(minimized(solid, cage, cage, *volume, request).cage.vertices, cage.vertices);
}

}  // namespace
}  // namespace encage::makers
