// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/energy/edges.h"
#include "cagegen/energy/vertex_areas.h"
#include "oracles/meshes.h"

#include <encage/energy.h>
#include <encage/error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace encage {
namespace {

using shapes::Random;

std::vector<EnergyPtr> all() {
  return {start_energy(), step_energy(), volume_energy(), surface_arap_energy(), find_energy("volume+0.1*sarap")};
}

Vertices displaced(Random& random, const Vertices& vertices, double by) {
  Vertices result = vertices;
  for (std::int64_t v = 0; v < result.rows(); ++v) result.row(v) += random.point(by).transpose();
  return result;
}

/// Everything that an energy may look at, each at a position of its own.
struct Scene {
  TriangleMesh fine;
  TriangleMesh rest;
  Vertices step_start;
  Vertices cage;

  Scene(Random& random, const TriangleMesh& mesh)
      : fine(shapes::scaled(mesh, 0.5)),
        rest(mesh),
        step_start(displaced(random, mesh.vertices, 0.1)),
        cage(displaced(random, mesh.vertices, 0.2)) {}
  EnergyState at(const Vertices& places) const { return {fine, rest, step_start, places}; }
};

std::vector<TriangleMesh> meshes() {
  return {shapes::tetrahedron(2, {5, 4, -3}), shapes::torus(1, 0.4, 7, 5), shapes::moved(shapes::sphere(1), {9, 9, 9}),
          shapes::joined(shapes::cube(1), shapes::cube(0.3, {4, 0, 0}))};
}

void expect_gradient(const CageEnergy& energy, const Scene& scene) {
  const Vertices gradient = energy.gradient(scene.at(scene.cage));
  ASSERT_EQ(gradient.rows(), scene.cage.rows());
  const double h = 1e-5;
  for (std::int64_t v = 0; v < scene.cage.rows(); ++v) {
    for (int k = 0; k < 3; ++k) {
      Vertices plus = scene.cage;
      Vertices minus = scene.cage;
      plus(v, k) += h;
      minus(v, k) -= h;
      const double slope = (energy.value(scene.at(plus)) - energy.value(scene.at(minus))) / (2 * h);
      EXPECT_NEAR(gradient(v, k), slope, 1e-8) << energy.name() << " vertex " << v << " axis " << k;
    }
  }
}

TEST(Energies, GradientsMatchFiniteDifferences) {
  Random random(1);
  for (const TriangleMesh& mesh : meshes()) {
    for (const EnergyPtr& energy : all()) expect_gradient(*energy, Scene(random, mesh));
  }
}

TEST(Energies, DescentLowersTheEnergy) {
  Random random(2);
  for (const TriangleMesh& mesh : meshes()) {
    const Scene scene(random, mesh);
    for (const EnergyPtr& energy : all()) {
      const Vertices descent = energy->descent(scene.at(scene.cage));
      EXPECT_LT((energy->gradient(scene.at(scene.cage)).array() * descent.array()).sum(), 0);
      const Vertices next = scene.cage + 1e-3 * descent;
      EXPECT_LT(energy->value(scene.at(next)), energy->value(scene.at(scene.cage))) << energy->name();
    }
  }
}

TEST(Energies, DisplacementsReachTheirMinimumInOneStep) {
  Random random(3);
  for (const TriangleMesh& mesh : meshes()) {
    const Scene scene(random, mesh);
    for (const EnergyPtr& energy : {start_energy(), step_energy()}) {
      ASSERT_TRUE(energy->first_step());
      const Vertices next = scene.cage + *energy->first_step() * energy->descent(scene.at(scene.cage));
      const Vertices& origin = energy->name() == "start" ? scene.rest.vertices : scene.step_start;
      EXPECT_TRUE(next.isApprox(origin, 1e-12)) << energy->name();
      EXPECT_EQ(energy->value(scene.at(origin)), 0);
      EXPECT_TRUE(energy->gradient(scene.at(origin)).isZero(0));
    }
  }
}

TEST(Energies, VolumeDescendsAtOneSpeed) {
  Random random(4);
  for (const TriangleMesh& mesh : meshes()) {
    const Scene scene(random, mesh);
    const Vertices descent = volume_energy()->descent(scene.at(scene.cage));
    for (std::int64_t v = 0; v < descent.rows(); ++v) EXPECT_NEAR(descent.row(v).norm(), 1, 1e-12);
  }
  EXPECT_FALSE(volume_energy()->first_step());
  // A vertex whose triangles have no area rests.
  const TriangleMesh point = shapes::mesh({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, {{0, 1, 2}});
  EXPECT_TRUE(volume_energy()->descent({point, point, point.vertices, point.vertices}).isZero(0));
}

TEST(Energies, KnownValues) {
  const TriangleMesh box = shapes::box({3, 4, 5}, {4, 6, 8});
  const auto value = [&](const EnergyPtr& energy, const Vertices& cage) {
    return energy->value({box, box, box.vertices, cage});
  };
  EXPECT_NEAR(value(volume_energy(), box.vertices), 6, 1e-12);
  const Vertices far = box.vertices.rowwise() + Eigen::RowVector3d(1e6, 0, 0);
  EXPECT_NEAR(value(volume_energy(), far), 6, 1e-9) << "wherever it is";
  EXPECT_NEAR(value(volume_energy(), Vertices(-box.vertices)), -6, 1e-12);
  // Moved by 2 as a whole: the surface's area, 22, times 4.
  const Vertices moved = box.vertices.rowwise() + Eigen::RowVector3d(0, 2, 0);
  EXPECT_NEAR(value(start_energy(), moved), 88, 1e-12);
  EXPECT_NEAR(value(step_energy(), moved), 88, 1e-12);
  EXPECT_EQ(start_energy()->value({box, box, moved, box.vertices}), 0);
  EXPECT_NEAR(step_energy()->value({box, box, moved, box.vertices}), 88, 1e-12);
}

TEST(Energies, VertexAreasSumToTheSurface) {
  const TriangleMesh box = shapes::box({0, 0, 0}, {1, 2, 3});
  EXPECT_NEAR(vertex_areas(box).sum(), 22, 1e-12);
  const TriangleMesh triangle = shapes::mesh({{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {9, 9, 9}}, {{0, 1, 2}});
  EXPECT_TRUE(vertex_areas(triangle).isApprox(Eigen::Vector4d(1, 1, 1, 0)));
}

TEST(Energies, GrowWithTheirDegree) {
  Random random(6);
  for (const TriangleMesh& mesh : meshes()) {
    const Scene scene(random, mesh);
    const Scene twice = [&] {
      Scene result = scene;
      for (Vertices* v : {&result.fine.vertices, &result.rest.vertices, &result.step_start, &result.cage}) *v *= 2;
      return result;
    }();
    for (const EnergyPtr& energy : all()) {
      const double value = energy->value(scene.at(scene.cage));
      EXPECT_NEAR(energy->value(twice.at(twice.cage)), value * std::pow(2, energy->degree()), 1e-11 * std::abs(value))
          << energy->name();
    }
  }
}

TEST(SurfaceArap, IsZeroForRigidMotionsAlone) {
  Random random(7);
  for (const TriangleMesh& mesh : meshes()) {
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
    const Vertices moved = (mesh.vertices * turn.transpose()).rowwise() + Eigen::RowVector3d(5, -1, 2);
    const EnergyState rigid{mesh, mesh, mesh.vertices, moved};
    EXPECT_LT(surface_arap_energy()->value(rigid), 1e-24);
    EXPECT_LT(surface_arap_energy()->gradient(rigid).norm(), 1e-12);

    // Half as large again: every edge is off by half of its length, at both of its ends.
    const Vertices larger = 1.5 * moved;
    double squared_lengths = 0;
    for (const auto& [a, b] : edges_of(mesh.triangles)) {
      squared_lengths += (mesh.vertices.row(a) - mesh.vertices.row(b)).squaredNorm();
    }
    EXPECT_NEAR(surface_arap_energy()->value({mesh, mesh, mesh.vertices, larger}), squared_lengths / 2, 1e-9);
    const Vertices mirrored = -mesh.vertices;
    EXPECT_GT(surface_arap_energy()->value({mesh, mesh, mesh.vertices, mirrored}), 0.1) << "no reflections";
  }
}

TEST(SurfaceArap, FindsBackToItsShape) {
  Random random(8);
  for (const TriangleMesh& mesh : meshes()) {
    const EnergyPtr energy = surface_arap_energy();
    Vertices cage = displaced(random, mesh.vertices, 0.05);
    const double first = energy->value({mesh, mesh, cage, cage});
    const Eigen::RowVector3d centre = cage.colwise().mean();
    double value = first;
    for (int i = 0; i < 300; ++i) {
      const EnergyState state{mesh, mesh, cage, cage};
      cage += *energy->first_step() * energy->descent(state);
      const double next = energy->value({mesh, mesh, cage, cage});
      EXPECT_LE(next, value * (1 + 1e-12) + 1e-24 * first);
      value = next;
    }
    EXPECT_LT(value, 1e-6 * first);
    EXPECT_LT((cage.colwise().mean() - centre).norm(), 1e-9) << "nothing pulls it away";
  }
}

TEST(SurfaceArap, VertexWithoutTrianglesRests) {
  TriangleMesh mesh = shapes::cube(1);
  mesh.vertices.conservativeResize(9, 3);
  mesh.vertices.row(8) << 5, 5, 5;
  const Vertices cage = 2 * mesh.vertices;
  const EnergyState state{mesh, mesh, mesh.vertices, cage};
  EXPECT_TRUE(surface_arap_energy()->descent(state).row(8).isZero(0));
  EXPECT_TRUE(surface_arap_energy()->descent(state).allFinite());
}

TEST(WeightedSum, AddsInUnitsOfAVolume) {
  Random random(9);
  const Scene scene(random, shapes::torus(1, 0.4, 7, 5));
  const EnergyState state = scene.at(scene.cage);
  const EnergyPtr sum = weighted_sum({{2, volume_energy()}, {0.5, surface_arap_energy()}, {3, start_energy()}});
  EXPECT_EQ(sum->name(), "2*volume+0.5*sarap+3*start");
  EXPECT_EQ(find_energy(sum->name())->name(), sum->name());
  const Vertices& rest = scene.rest.vertices;
  const double diagonal = (rest.colwise().maxCoeff() - rest.colwise().minCoeff()).norm();
  EXPECT_NEAR(sum->value(state),
              2 * volume_energy()->value(state) + 0.5 * diagonal * surface_arap_energy()->value(state) +
                  3 * start_energy()->value(state) / diagonal,
              1e-12);
  EXPECT_EQ(weighted_sum({{1, volume_energy()}}), volume_energy());
  EXPECT_EQ(find_energy("1*volume"), volume_energy()) << "which is followed by the tightening of vertices";
  EXPECT_EQ(find_energy("1e-3*start+2e+1*step")->name(), "0.001*start+20*step");
}

TEST(WeightedSum, BadTermsAreNamed) {
  const auto message = [](const char* text) -> std::string {
    try {
      find_energy(text);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("volume+-1*sarap"), "energy 'sarap': the weight -1 is not positive and finite");
  EXPECT_EQ(message("volume+0*sarap"), "energy 'sarap': the weight 0 is not positive and finite");
  EXPECT_EQ(message("inf*volume"), "energy 'volume': the weight inf is not positive and finite");
  EXPECT_EQ(message("nan*volume"), "energy 'volume': the weight nan is not positive and finite");
  EXPECT_EQ(message("x*volume"), "energy 'x*volume': 'x' is not a number");
  EXPECT_EQ(message("1 *volume"), "energy '1 *volume': '1 ' is not a number");
  EXPECT_EQ(message("*volume"), "energy '*volume': '' is not a number");
  EXPECT_NE(message("volume+"), "");
  EXPECT_NE(message("volume+2*tightness"), "");
  EXPECT_THROW(weighted_sum({}), Error);
  EXPECT_THROW(weighted_sum({{1, nullptr}}), Error);
}

TEST(FindEnergy, ByName) {
  for (const EnergyPtr& energy : all()) EXPECT_EQ(find_energy(energy->name())->name(), energy->name());
  try {
    find_energy("Volume");
    FAIL() << "names are exact";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "no energy is called 'Volume'; known: start, step, volume, sarap, and sums such as volume+0.1*sarap");
  }
  EXPECT_THROW(find_energy(""), Error);
}

/// The sum of the heights of the vertices: an energy as a user would write it.
class Heights final : public CageEnergy {
  std::string name() const override { return "heights"; }
  double value(const EnergyState& state) const override { return state.cage.col(2).sum(); }
  Vertices gradient(const EnergyState& state) const override {
    Vertices result = Vertices::Zero(state.cage.rows(), 3);
    result.col(2).setOnes();
    return result;
  }
};

TEST(CageEnergy, TheUsersOwn) {
  Random random(5);
  const Heights own;
  const CageEnergy& energy = own;
  TriangleMesh mesh = shapes::cube(1);
  mesh.vertices.conservativeResize(9, 3);
  mesh.vertices.row(8).setZero();
  const Scene scene(random, mesh);
  expect_gradient(energy, scene);
  EXPECT_FALSE(energy.first_step());
  // By default the negative gradient over the area; over 1 where there is none.
  const Vertices descent = energy.descent(scene.at(scene.cage));
  const Eigen::VectorXd area = vertex_areas(mesh);
  for (std::int64_t v = 0; v < 8; ++v) EXPECT_NEAR(descent(v, 2), -1 / area[v], 1e-12);
  EXPECT_EQ(descent(8, 2), -1);
  EXPECT_TRUE(descent.leftCols(2).isZero(0));
}

}  // namespace
}  // namespace encage
