// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/meshes.h"
#include "src/mesh/portable_trig.h"

#include <encage/mass_properties.h>

#include <gtest/gtest.h>

#include <limits>

namespace encage {
namespace {

Eigen::Matrix3d turned(double x, double y, double z) {
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  int axis = 0;
  for (const double turns : {x, y, z}) {
    const SinCos t = sincos_turns(turns);
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
    one(i, i) = one(j, j) = t.cos;
    one(i, j) = -t.sin;
    one(j, i) = t.sin;
    r = one * r;
    ++axis;
  }
  return r;
}

double largest_entry(const Eigen::MatrixXd& m) { return m.cwiseAbs().maxCoeff(); }

void expect_right_handed_and_orthonormal(const Eigen::Matrix3d& axes) {
  EXPECT_LT(largest_entry(axes.transpose() * axes - Eigen::Matrix3d::Identity()), 1e-14);
  EXPECT_NEAR(axes.determinant(), 1, 1e-14);
}

TEST(Mass, OfABoxIsInTheTextbooks) {
  const MassProperties m = mass_properties(shapes::box({1, 2, 3}, {3, 5, 7}));  // 2 x 3 x 4
  EXPECT_NEAR(m.mass, 24, 1e-13);
  EXPECT_LT(largest_entry(m.centre - Eigen::Vector3d(2, 3.5, 5)), 1e-14);
  EXPECT_LT(largest_entry(m.moments - Eigen::Vector3d(2 * (4 + 9), 2 * (4 + 16), 2 * (9 + 16))), 1e-12);
  EXPECT_LT(largest_entry(m.axes.cwiseAbs() - Eigen::Matrix3d(Eigen::Matrix3d::Identity().rowwise().reverse())), 1e-14);
  EXPECT_NEAR(m.radius, std::sqrt(1 + 2.25 + 4), 1e-14);
  expect_right_handed_and_orthonormal(m.axes);
}

TEST(Mass, OfATetrahedronIsInTheTextbooks) {
  // Volume 1/6, centre at a quarter; diagonal of the tensor 1/80 · (a² + b²), products of inertia.
  const MassProperties m = mass_properties(shapes::tetrahedron(1));
  EXPECT_NEAR(m.mass, 1.0 / 6, 1e-16);
  EXPECT_LT(largest_entry(m.centre - Eigen::Vector3d::Constant(0.25)), 1e-15);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(m.inertia(i, j), i == j ? 1.0 / 80 : 1.0 / 480, 1e-16);
  }
  // Of the matrix with equal entries d and o: d - o twice, d + 2 o once.
  EXPECT_NEAR(m.moments[0], 1.0 / 80 - 1.0 / 480, 1e-16);
  EXPECT_NEAR(m.moments[1], 1.0 / 80 - 1.0 / 480, 1e-16);
  EXPECT_NEAR(m.moments[2], 1.0 / 80 + 2.0 / 480, 1e-16);
}

TEST(Mass, OfAFineSphereNearsTheBall) {
  const MassProperties m = mass_properties(shapes::sphere(5));
  const double pi = std::acos(-1.0);
  EXPECT_NEAR(m.mass, 4 * pi / 3, 0.01);
  EXPECT_LT(largest_entry(m.moments - Eigen::Vector3d::Constant(8 * pi / 15)), 0.01);
  EXPECT_LT(largest_entry(m.centre), 1e-14);
}

TEST(Mass, TurnsAndMovesWithTheMesh) {
  const TriangleMesh mesh = shapes::joined(shapes::box({0, 0, 0}, {1, 2, 3}), shapes::tetrahedron(1, {5, 1, 1}));
  const MassProperties m = mass_properties(mesh);
  const Eigen::Matrix3d r = turned(0.1, 0.23, 0.4);
  const Eigen::Vector3d shift(30, -20, 10);
  TriangleMesh moved = mesh;
  moved.vertices = mesh.vertices * r.transpose();
  moved.vertices.rowwise() += shift.transpose();
  const MassProperties n = mass_properties(moved);
  EXPECT_NEAR(n.mass, m.mass, 1e-12);
  EXPECT_LT(largest_entry(n.centre - (r * m.centre + shift)), 1e-13);
  EXPECT_LT(largest_entry(n.inertia - r * m.inertia * r.transpose()), 1e-12);
  EXPECT_LT(largest_entry(n.moments - m.moments), 1e-12);
  EXPECT_NEAR(n.radius, m.radius, 1e-12);
  const Eigen::Matrix3d along = n.axes.transpose() * r * m.axes;  // the same axes, up to their sense
  EXPECT_LT(largest_entry(along.cwiseAbs() - Eigen::Matrix3d::Identity()), 1e-10);
}

TEST(Mass, RefusesWhatIsNoBody) {
  TriangleMesh open = shapes::cube(1);
  open.triangles.conservativeResize(11, 3);
  EXPECT_THROW(mass_properties(open), Error);
  EXPECT_THROW(mass_properties(shapes::flipped(shapes::cube(1))), Error);
  EXPECT_THROW(mass_properties(TriangleMesh{}), Error);
  TriangleMesh bad = shapes::cube(1);
  bad.vertices(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(mass_properties(bad), Error);
  EXPECT_THROW(mass_properties(shapes::box({0, 0, 0}, {1, 1, 0})), Error);
}

}  // namespace
}  // namespace encage
