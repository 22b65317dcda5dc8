// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/reinflate.h"

#include "tests/cagegen/geometry/shapes.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace encage::makers {
namespace {

constexpr double test_clearance = 1e-4;

/// F that has flowed in equal steps from its home position to `inside`.
FlowResult flowed(const TriangleMesh& fine, const Vertices& inside, int steps) {
  FlowResult result{true, inside, FlowHistory(fine.vertices), 0, {}};
  for (int step = 1; step <= steps; ++step) {
    std::vector<std::int32_t> moved;
    std::vector<Eigen::Vector3f> positions;
    const double part = static_cast<double>(step) / steps;
    for (std::int32_t v = 0; v < fine.vertices.rows(); ++v) {
      moved.push_back(v);
      positions.push_back(((1 - part) * fine.vertices.row(v) + part * inside.row(v)).cast<float>());
    }
    result.history.push(std::move(moved), std::move(positions));
  }
  if (steps > 0) result.positions = result.history.at(steps);
  return result;
}

struct Outcome {
  ReinflateResult result;
  TriangleMesh cage;
};

Outcome run(
    const TriangleMesh& fine, const TriangleMesh& coarse, const FlowResult& flow, const EnergyPtr& energy,
    FlowPath path = FlowPath::straight, int threads = 1, std::function<void()> check = [] {},
    double self_clearance = 6 * test_clearance) {
  ContactSolver solver(coarse, {test_clearance, self_clearance, threads, std::move(check)});
  ReinflateRequest request;
  request.fine = &fine;
  request.rest = &coarse;
  request.flowed = &flow;
  request.energy = energy.get();
  request.path = path;
  const ReinflateResult result = reinflate(solver, request, Obstacle(fine));
  return {result, solver.mesh()};
}

void expect_nested(const TriangleMesh& fine, const Outcome& outcome) {
  ASSERT_TRUE(outcome.result.reached) << outcome.result.failure;
  EXPECT_EQ(outcome.result.failure, "");
  EXPECT_GE(outcome.result.steps, 1);
  const CertifyResult proof = certify(fine, Solid::closed, outcome.cage);
  ASSERT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, 0.999 * test_clearance);
  EXPECT_EQ(outcome.cage.vertices, shapes::rounded(outcome.cage).vertices);
}

TEST(Reinflate, ASphereFillsItsCage) {
  const TriangleMesh fine = shapes::sphere(3);
  const TriangleMesh coarse = shapes::rounded(shapes::scaled(shapes::sphere(1), 0.95));
  const FlowResult flow = flowed(fine, Vertices(0.6 * fine.vertices), 6);
  for (const EnergyPtr& energy : {step_energy(), start_energy(), volume_energy()}) {
    for (const FlowPath path : {FlowPath::straight, FlowPath::history}) {
      SCOPED_TRACE(energy->name());
      const Outcome outcome = run(fine, coarse, flow, energy, path);
      expect_nested(fine, outcome);
      EXPECT_EQ(outcome.result.steps, path == FlowPath::history ? 6 : 3);
      EXPECT_EQ(outcome.result.halvings, 0);
      // Outside of the unit sphere's polyhedron, and not farther than planes tangent to it need.
      for (std::int64_t v = 0; v < outcome.cage.vertices.rows(); ++v) {
        EXPECT_GT(outcome.cage.vertices.row(v).norm(), 0.99);
        EXPECT_LT(outcome.cage.vertices.row(v).norm(), 1.45);
      }
    }
  }
}

TEST(Reinflate, AFlowedMeshThatIsHomeMovesNothing) {
  const TriangleMesh fine = shapes::scaled(shapes::sphere(2), 0.5);
  const TriangleMesh coarse = shapes::rounded(shapes::sphere(1));
  const FlowResult flow = flowed(fine, fine.vertices, 0);
  for (const FlowPath path : {FlowPath::straight, FlowPath::history}) {
    for (const EnergyPtr& energy : {step_energy(), start_energy()}) {
      const Outcome outcome = run(fine, coarse, flow, energy, path);
      expect_nested(fine, outcome);
      EXPECT_EQ(outcome.cage.vertices, coarse.vertices) << energy->name();
    }
  }
  // The volume is drawn in all the same.
  const Outcome outcome = run(fine, coarse, flow, volume_energy());
  expect_nested(fine, outcome);
  EXPECT_LT(signed_volume(outcome.cage), signed_volume(coarse));
}

TEST(Reinflate, EnergiesDecideWhereTheCageIs) {
  // F swings out on its way home and back: what pushed the cage there is gone in the end.
  const TriangleMesh fine = shapes::scaled(shapes::sphere(3), 0.7);
  const TriangleMesh coarse = shapes::rounded(shapes::sphere(1));
  FlowResult flow{true, {}, FlowHistory(fine.vertices), 0, {}};
  for (const double factor : {1.2, 1.5, 1.2, 0.6}) {
    std::vector<std::int32_t> moved;
    std::vector<Eigen::Vector3f> positions;
    for (std::int32_t v = 0; v < fine.vertices.rows(); ++v) {
      moved.push_back(v);
      positions.push_back((factor * fine.vertices.row(v)).cast<float>());
    }
    flow.history.push(std::move(moved), std::move(positions));
  }
  flow.positions = flow.history.at(4);
  const auto volume = [&](const EnergyPtr& energy) {
    const Outcome outcome = run(fine, coarse, flow, energy, FlowPath::history);
    expect_nested(fine, outcome);
    return signed_volume(outcome.cage);
  };
  const double step = volume(step_energy());
  const double start = volume(start_energy());
  const double tight = volume(volume_energy());
  EXPECT_GT(step, 1.15 * signed_volume(coarse)) << "stays where it was pushed";
  EXPECT_NEAR(start, signed_volume(coarse), 0.02) << "comes back to where it started";
  EXPECT_LT(tight, step);
}

TEST(Reinflate, ComponentsStayInside) {
  const TriangleMesh fine = shapes::joined(shapes::sphere(2), shapes::moved(shapes::sphere(2), {2.3, 0, 0}));
  const TriangleMesh coarse = shapes::rounded(shapes::joined(
      shapes::scaled(shapes::sphere(1), 0.9), shapes::moved(shapes::scaled(shapes::sphere(1), 0.9), {2.3, 0, 0})));
  Vertices inside = 0.5 * fine.vertices;
  inside.bottomRows(fine.vertices.rows() / 2).col(0).array() += 1.15;
  for (const FlowPath path : {FlowPath::straight, FlowPath::history}) {
    const Outcome outcome = run(fine, coarse, flowed(fine, inside, 5), step_energy(), path);
    expect_nested(fine, outcome);
    for (const int threads : {2, 3}) {
      const Outcome other = run(fine, coarse, flowed(fine, inside, 5), step_energy(), path, threads);
      EXPECT_EQ(other.cage.vertices, outcome.cage.vertices);
    }
  }
}

TEST(Reinflate, TheSameForAnyNumberOfThreads) {
  const TriangleMesh fine = shapes::torus(1, 0.4, 40, 20);
  const TriangleMesh coarse = shapes::rounded(shapes::torus(1, 0.4, 24, 12));
  const TriangleMesh thin = shapes::torus(1, 0.2, 40, 20);
  const FlowResult flow = flowed(fine, thin.vertices, 4);
  for (const EnergyPtr& energy : {step_energy(), volume_energy()}) {
    const Outcome one = run(fine, coarse, flow, energy);
    expect_nested(fine, one);
    for (const int threads : {2, 3}) {
      const Outcome other = run(fine, coarse, flow, energy, FlowPath::straight, threads);
      EXPECT_EQ(other.cage.vertices, one.cage.vertices);
      EXPECT_EQ(other.result.steps, one.result.steps);
    }
  }
}

/// Two plates that come together around the two walls of a cage between them, until `gap` is left.
struct Pinch {
  TriangleMesh fine;
  TriangleMesh coarse;
  FlowResult flow;
};

Pinch pinch(double gap) {
  const double half = 0.5 + gap / 2;
  const TriangleMesh fine = shapes::joined(shapes::box({-1, -1, -half - 1}, {1, 1, -gap / 2}),
                                           shapes::box({-1, -1, gap / 2}, {1, 1, half + 1}));
  const TriangleMesh coarse = shapes::rounded(shapes::joined(shapes::box({-1.1, -1.1, -1.7}, {1.1, 1.1, -0.05}),
                                                             shapes::box({-1.1, -1.1, 0.05}, {1.1, 1.1, 1.7})));
  Vertices inside = fine.vertices;
  inside.topRows(8).col(2).array() -= 0.1;
  inside.bottomRows(8).col(2).array() += 0.1;
  return {fine, coarse, flowed(fine, inside, 4)};
}

TEST(Reinflate, APinchIsNamed) {
  const Pinch p = pinch(1.5 * test_clearance);
  for (const FlowPath path : {FlowPath::straight, FlowPath::history}) {
    const Outcome outcome = run(p.fine, p.coarse, p.flow, step_energy(), path);
    ASSERT_FALSE(outcome.result.reached);
    EXPECT_GT(outcome.result.halvings, 0);
    EXPECT_GT(outcome.result.reliefs, 0);
    double x = 0;
    double y = 0;
    double z = 1;
    double percent = 0;
    int faces = 0;
    const int read =
        std::sscanf(outcome.result.failure.c_str(),
                    "the re-inflation is pinched at %lf %% of the way: %d faces of the cage jam near (%lf, %lf, %lf)",
                    &percent, &faces, &x, &y, &z);
    ASSERT_EQ(read, 5) << outcome.result.failure;
    EXPECT_GE(percent, 40);
    EXPECT_LE(percent, 100);
    EXPECT_GE(faces, 1);
    EXPECT_LT(std::abs(z), 0.1) << "between the plates";
    // What is left is a cage, around F where it came to a halt.
    const TriangleMesh seeds = shapes::joined(shapes::cube(0.1, {0, 0, -0.8}), shapes::cube(0.1, {0, 0, 0.8}));
    const CertifyResult proof = certify(seeds, Solid::closed, outcome.cage);
    EXPECT_TRUE(proof.holds) << proof.reason;
  }
}

TEST(Reinflate, StrandsComeCloserWhereTheyWouldJam) {
  // Room for the clearances to F and little more: not for the distance that the walls of the cage should keep.
  const Pinch p = pinch(5 * test_clearance);
  const Outcome outcome = run(p.fine, p.coarse, p.flow, step_energy());
  expect_nested(p.fine, outcome);
  EXPECT_GT(outcome.result.reliefs, 0);
  const Pinch wide = pinch(20 * test_clearance);
  const Outcome roomy = run(wide.fine, wide.coarse, wide.flow, step_energy());
  expect_nested(wide.fine, roomy);
  EXPECT_EQ(roomy.result.reliefs, 0);
}

TEST(Reinflate, AMotionThatIsTooLongIsCutInTwo) {
  // A small component crosses the wall of the cage and comes to rest outside in one step: the wall has to be taken
  // along, which only shorter steps show.
  const TriangleMesh small = shapes::tetrahedron(0.2, {3, 0, 0});
  const TriangleMesh fine = shapes::joined(shapes::cube(0.3), small);
  const TriangleMesh coarse = shapes::rounded(shapes::scaled(shapes::sphere(2), 1));
  Vertices inside = fine.vertices;
  inside.bottomRows(4).col(0).array() -= 2.5;
  const Outcome outcome = run(fine, coarse, flowed(fine, inside, 1), step_energy());
  expect_nested(fine, outcome);
  EXPECT_GT(outcome.result.halvings, 0);
}

TEST(Reinflate, CheckMayStopIt) {
  const TriangleMesh fine = shapes::sphere(2);
  const TriangleMesh coarse = shapes::rounded(shapes::sphere(1));
  const FlowResult flow = flowed(fine, Vertices(0.5 * fine.vertices), 3);
  int calls = 0;
  const auto stop = [&] {
    if (++calls == 3) throw Cancelled();
  };
  EXPECT_THROW(run(fine, coarse, flow, step_energy(), FlowPath::straight, 1, stop), Cancelled);
  EXPECT_EQ(calls, 3);
}

}  // namespace
}  // namespace encage::makers
