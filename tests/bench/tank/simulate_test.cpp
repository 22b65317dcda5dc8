// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/simulate.h"

#include "bench/tank/interpenetration.h"
#include "oracles/meshes.h"
#include "tests/bench/tank/ball_detector.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace encage::tank {
namespace {

TriangleMesh in_float(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

ShapePtr shape_of(const TriangleMesh& mesh) {
  CageHierarchy hierarchy;
  hierarchy.fine = mesh;
  return make_shape(hierarchy);
}

TriangleMesh ring() { return in_float(shapes::torus(0.7, 0.25, 8, 5)); }

TankOptions few(int bodies, double seconds) {
  TankOptions options;
  options.bodies = bodies;
  options.seconds = seconds;
  options.drop_interval = 0.3;
  options.dt = 1.0 / 480;
  return options;
}

/// PairContact over all pairs of triangles.
class BruteForce : public ShapeDetector {
 public:
  BruteForce(const ShapePtr& shape, std::int64_t triangles, const Eigen::Vector3d& centre)
      : ShapeDetector(shape, centre), shape_(shape), triangles_(static_cast<std::int32_t>(triangles)) {}

  std::optional<Contact> pair(const Motion& a, const Motion& b, const ContactOptions& options) const override {
    PairContact contact(*shape_, a, *shape_, b, options);
    for (std::int32_t i = 0; i < triangles_; ++i) {
      for (std::int32_t j = 0; j < triangles_; ++j) contact.test(i, j);
    }
    return contact.first();
  }

 private:
  ShapePtr shape_;
  std::int32_t triangles_;
};

TEST(Simulate, GivesTheSameBitsTwiceAndOthersForAnotherSeed) {
  const TriangleMesh mesh = ring();
  const MassProperties mass = mass_properties(mesh);
  TankOptions options = few(4, 2);
  const Simulation once = simulate(shape_of(mesh), mass, options), again = simulate(shape_of(mesh), mass, options);
  EXPECT_EQ(once.trajectory_hash, again.trajectory_hash);
  EXPECT_GT(once.statistics.filter.conflicts, 10);
  options.seed = 5;
  EXPECT_NE(simulate(shape_of(mesh), mass, options).trajectory_hash, once.trajectory_hash);
}

TEST(Simulate, EqualsBruteForceDetection) {
  const TriangleMesh mesh = ring();
  const MassProperties mass = mass_properties(mesh);
  const TankOptions options = few(4, 1.5);
  const ShapePtr shape = shape_of(mesh);
  const Simulation fast = simulate(shape, mass, options);
  const Simulation slow = simulate(BruteForce(shape, mesh.triangles.rows(), mass.centre), mass, options);
  EXPECT_GT(fast.statistics.filter.conflicts, 20);
  EXPECT_EQ(fast.trajectory_hash, slow.trajectory_hash);
  EXPECT_EQ(fast.statistics.filter.conflicts, slow.statistics.filter.conflicts);
}

TEST(Simulate, RecordsWhatWasTriedAndCommitted) {
  const TriangleMesh mesh = ring();
  const MassProperties mass = mass_properties(mesh);
  const TankOptions options = few(4, 1.5);
  const Simulation s = simulate(shape_of(mesh), mass, options);
  ASSERT_EQ(s.recording.steps.size(), 720U);
  ASSERT_EQ(s.poses.size(), 721U);
  EXPECT_EQ(s.recording.dt, options.dt);
  EXPECT_EQ(s.statistics.energy.size(), 720U);
  int differences = 0;
  for (std::size_t k = 0; k < s.recording.steps.size(); ++k) {
    const bench::RecordedStep& step = s.recording.steps[k];
    EXPECT_EQ(step.step, static_cast<std::int64_t>(k));
    EXPECT_EQ(s.poses[k].step, static_cast<std::int64_t>(k));
    ASSERT_EQ(step.bodies.size(), std::min<std::size_t>(k / 144 + 1, 4));
    ASSERT_EQ(s.poses[k].bodies.size(), step.bodies.size());
    for (std::size_t b = 0; b < step.bodies.size(); ++b) {
      EXPECT_EQ(step.bodies[b].body, static_cast<std::int32_t>(b));
      EXPECT_EQ(step.bodies[b].motion.start.matrix(), s.poses[k].bodies[b].pose.matrix());
      EXPECT_TRUE(is_usable(step.bodies[b].motion));
      differences += step.bodies[b].motion.end.matrix() != s.poses[k + 1].bodies[b].pose.matrix();
    }
  }
  EXPECT_GT(differences, 10) << "trials that collided were not committed";
  EXPECT_LT(differences, 720);
}

TEST(Simulate, ABallBouncesInTheTank) {
  const TriangleMesh mesh = in_float(shapes::sphere(3));
  const MassProperties mass = mass_properties(mesh);
  TankOptions options = few(2, 3);
  options.half_width = 1.5;
  const Simulation s = simulate(shape_of(mesh), mass, options);
  double lowest = 1e9;
  for (const PoseStep& step : s.poses) {
    for (const BodyPose& body : step.bodies) {
      const Vertices world =
          (mesh.vertices * body.pose.linear().transpose()).rowwise() + body.pose.translation().transpose();
      EXPECT_LE(world.leftCols<2>().cwiseAbs().maxCoeff(), 1.5);
      lowest = std::min(lowest, world.col(2).minCoeff());
    }
  }
  EXPECT_GE(lowest, 0);
  EXPECT_LT(lowest, 1e-2);
  EXPECT_EQ(s.statistics.filter.held, 0);
  EXPECT_EQ(s.statistics.body_steps, 2 * 1440 - 144);
}

TEST(Simulate, LedgerOfTheEnergy) {
  const TriangleMesh mesh = ring();
  const MassProperties mass = mass_properties(mesh);
  for (const TankScene scene : {TankScene::drop, TankScene::bouncing, TankScene::resting}) {
    TankOptions options = few(3, 3);
    options.scene = scene;
    options.restitution = 0.9;
    const Statistics s = simulate(shape_of(mesh), mass, options).statistics;
    const double total = s.energy.back().kinetic + s.energy.back().potential;
    EXPECT_GT(s.energy_lost, 0.05 * s.energy_entered);
    EXPECT_NEAR(total, s.energy_entered + s.energy_added - s.energy_lost + s.energy_drift, 1e-9);
    EXPECT_LT(std::abs(s.energy_drift), 1e-3 * s.energy_lost) << name(scene);
    if (scene == TankScene::drop) {
      EXPECT_EQ(s.energy_added, 0);
    } else {
      EXPECT_EQ(s.energy_added > 0, scene == TankScene::bouncing);
    }
  }
}

TEST(Simulate, BouncingGoesOnAndRestingComesToRest) {
  const MassProperties mass = mass_properties(shapes::sphere(3));
  const BallDetector balls(mass.radius);
  TankOptions options = few(5, 8);
  options.restitution = 0.8;
  const double unit = mass.mass * options.gravity * mass.radius * options.bodies;
  options.scene = TankScene::bouncing;
  const Statistics bouncing = simulate(balls, mass, options).statistics;
  for (std::size_t k = bouncing.energy.size() / 2; k < bouncing.energy.size(); ++k) {
    ASSERT_GT(bouncing.energy[k].kinetic, 0.7 * unit * options.floor_height);
  }
  options.scene = TankScene::resting;
  const Statistics resting = simulate(balls, mass, options).statistics;
  EXPECT_LT(resting.energy.back().kinetic, 1.5 * options.rest_height * unit);
  EXPECT_LT(resting.energy.back().potential, 0.9 * bouncing.energy.back().potential);
}

TEST(Simulate, BodiesNeverInterpenetrateUnlessTold) {
  const TriangleMesh mesh = ring();
  const MassProperties mass = mass_properties(mesh);
  TankOptions options = few(6, 3);
  const auto sampled = [&](const Simulation& s) {
    std::int64_t count = 0;
    for (std::size_t k = 0; k < s.poses.size(); k += 24) count += interpenetrations(mesh, s.poses[k]);
    return count;
  };
  EXPECT_EQ(sampled(simulate(shape_of(mesh), mass, options)), 0);
  options.collisions = false;
  EXPECT_GT(sampled(simulate(shape_of(mesh), mass, options)), 20);
}

TEST(Simulate, JammedBodiesAreHeldAndStayApart) {
  const TriangleMesh mesh = ring();
  const MassProperties mass = mass_properties(mesh);
  TankOptions options = few(6, 5);
  options.scene = TankScene::resting;
  options.rest_height = 0;
  options.restitution = 0;
  options.dt = 1.0 / 120;
  const Simulation s = simulate(shape_of(mesh), mass, options);
  EXPECT_GT(s.statistics.filter.held, 100);
  EXPECT_GE(s.statistics.most_held, 2);
  EXPECT_GT(s.statistics.most_passes, 8);
  std::int64_t count = 0;
  for (std::size_t k = 0; k < s.poses.size(); k += 10) count += interpenetrations(mesh, s.poses[k]);
  EXPECT_EQ(count, 0);
}

TEST(Simulate, ReportsProgressAndCanBeCancelled) {
  const MassProperties mass = mass_properties(shapes::sphere(2));
  const BallDetector balls(mass.radius);
  std::vector<double> seen;
  std::atomic<bool> cancel = false;
  SimulationContext context;
  context.progress = [&](double fraction) { seen.push_back(fraction); };
  context.cancel = &cancel;
  const TankOptions options = few(1, 0.1);
  simulate(balls, mass, options, context);
  EXPECT_EQ(seen.size(), 48U);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_EQ(seen.back(), 1);
  seen.clear();
  context.progress = [&](double fraction) {
    seen.push_back(fraction);
    cancel = seen.size() == 10;
  };
  EXPECT_THROW(simulate(balls, mass, options, context), Cancelled);
  EXPECT_EQ(seen.size(), 10U);
}

TEST(Simulate, RefusesBadInput) {
  const TriangleMesh mesh = ring();
  const MassProperties mass = mass_properties(mesh);
  EXPECT_THROW(simulate(shape_of(mesh), mass, few(0, 1)), Error);
  CageHierarchy cage_only;
  CageLevel level;
  level.mesh = in_float(shapes::cube(2));
  cage_only.levels.push_back(level);
  EXPECT_THROW(simulate(make_shape(cage_only), mass, few(1, 1)), Error);
}

}  // namespace
}  // namespace encage::tank
