// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/octopus.h"

#include "cagegen/certify/certify.h"

#include <encage/error.h>
#include <encage/mass_properties.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace encage::octopus {
namespace {

const TriangleMesh& octopus_50k() {
  static const TriangleMesh mesh = make_octopus(50'000);
  return mesh;
}

void expect_sound(const TriangleMesh& mesh, std::int64_t faces) {
  EXPECT_LE(std::abs(mesh.triangles.rows() - faces), faces / 100);
  EXPECT_TRUE(is_closed(mesh));
  const CertifyResult proof = certify_alone(mesh);
  EXPECT_TRUE(proof.holds) << proof.reason;
  EXPECT_EQ(proof.certificate.genus, 0);
  std::vector<std::int32_t> label;
  EXPECT_EQ(triangle_components(mesh, label), 1);
  EXPECT_GT(signed_volume(mesh), 0.15);
}

TEST(Octopus, IsASoundSurface) { expect_sound(octopus_50k(), 50'000); }

TEST(Octopus, IsASoundSurfaceAtOtherSizes) {
  for (const std::int64_t faces : {fewest_octopus_faces, std::int64_t{23'456}}) {
    SCOPED_TRACE(faces);
    expect_sound(make_octopus(faces), faces);
  }
}

TEST(Octopus, HasHalfAMillionFacesByDefault) {
  const TriangleMesh mesh = make_octopus();
  EXPECT_NEAR(static_cast<double>(mesh.triangles.rows()), 500'000, 5'000);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_EQ(mesh.vertices.rows() - mesh.triangles.rows() / 2, 2);
  // The same animal at another resolution.
  EXPECT_NEAR(signed_volume(mesh), signed_volume(octopus_50k()), 0.05 * signed_volume(mesh));
}

TEST(Octopus, IsTheSameTwice) {
  const TriangleMesh again = make_octopus(50'000);
  EXPECT_EQ(again.vertices, octopus_50k().vertices);
  EXPECT_EQ(again.triangles, octopus_50k().triangles);
}

TEST(Octopus, VerticesAreExactInFloat) {
  for (const double x : octopus_50k().vertices.reshaped()) {
    volatile float rounded = static_cast<float>(x);
    EXPECT_EQ(static_cast<double>(rounded), x);
  }
}

TEST(Octopus, IsCentredOfUnitSizeAndSpreadsItsArms) {
  const TriangleMesh& mesh = octopus_50k();
  EXPECT_NEAR(mesh.vertices.rowwise().norm().maxCoeff(), 1, 1e-6);
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    moment += a.dot(b.cross(c)) / 24 * (a + b + c);
  }
  EXPECT_LT(moment.norm(), 1e-6);
  // Arms on all sides, about as far to the left as to the right, and farther than the animal is tall.
  const Eigen::AlignedBox3d box = bounds(mesh);
  EXPECT_LT(std::abs(box.center().x()), 0.1);
  EXPECT_LT(std::abs(box.center().y()), 0.2);
  EXPECT_GT(box.sizes().x(), 1.4);
  EXPECT_GT(box.sizes().y(), 1.4);
  EXPECT_LT(box.sizes().z(), box.sizes().x());
}

TEST(Octopus, RefusesSizesItCannotShow) {
  EXPECT_THROW(make_octopus(fewest_octopus_faces - 1), Error);
  EXPECT_THROW(make_octopus(most_octopus_faces + 1), Error);
  EXPECT_THROW(make_octopus(-5), Error);
}

TEST(Octopus, HasItsCentreOfMassInTheMiddle) {
  const MassProperties m = mass_properties(make_octopus(fewest_octopus_faces));
  EXPECT_LT(m.centre.cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_NEAR(m.radius, 1, 1e-6);
  // No body of radius 1 has more than its mass at the rim; moments satisfy the triangle inequality.
  EXPECT_GT(m.moments[0], 0.01 * m.mass);
  EXPECT_LT(m.moments[2], m.mass);
  EXPECT_LT(m.moments[2], m.moments[0] + m.moments[1]);
  // The octopus is its own mirror image in x: that axis is a principal one.
  EXPECT_GT(m.axes.row(0).cwiseAbs().maxCoeff(), 0.99);
}

}  // namespace
}  // namespace encage::octopus
