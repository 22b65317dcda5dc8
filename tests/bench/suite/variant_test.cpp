// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/assets/variant.h"

#include "bench/suite/assets/base_mesh.h"
#include "oracles/meshes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <set>
#include <tuple>

namespace encage::assets {
namespace {

/// Without symmetry, far from 0.
TriangleMesh source() {
  TriangleMesh mesh = shapes::torus(1, 0.375, 12, 8);
  mesh.vertices.col(1) *= 2;
  mesh.vertices.rowwise() += Eigen::RowVector3d(16, -3, 0.5);
  mesh = shapes::joined(mesh, shapes::tetrahedron(0.5, {12, 1, 3}));
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

TEST(Variants, KeepEveryCertificate) {
  BakeOptions options;
  options.faces = {60, 20};
  options.method = BakeMethod::collapse;
  const TriangleMesh mesh = source();
  const CageHierarchy base = bake(mesh, options);
  ASSERT_EQ(base.levels.size(), 2u);
  for (int number = 0; number < 144; number += number < 48 ? 1 : 13) {
    SCOPED_TRACE(number);
    const Variant variant = make_variant(number);
    const SourceMesh turned = sanitize(transform(mesh, variant));
    const CageHierarchy hierarchy = transform(base, variant, turned.hash);
    for (const CheckReport::Check& check : check_asset(hierarchy, &turned).checks) {
      EXPECT_EQ(check.verdict, CheckVerdict::holds) << check.subject << ": " << check.detail;
    }
  }
}

TEST(Variants, AreDifferent) {
  const TriangleMesh mesh = source();
  std::set<std::tuple<double, double, double>> places;
  for (int number = 0; number < 144; ++number) {
    const TriangleMesh turned = transform(mesh, make_variant(number));
    EXPECT_EQ(signed_volume(turned) > 0, true) << number;
    places.insert({turned.vertices(0, 0), turned.vertices(0, 1), turned.vertices(0, 2)});
  }
  EXPECT_EQ(places.size(), 144u);
}

TEST(BaseMeshes, AreClosedSolidsOfTheirOwn) {
  std::set<Eigen::Index> sizes;
  for (int number = 0; number < 6; ++number) {
    const SourceMesh mesh = sanitize(make_base_mesh(number, 25'000));
    EXPECT_TRUE(mesh.manifold);
    EXPECT_EQ(mesh.solid, Solid::closed);
    EXPECT_EQ(mesh.report.flipped_components, 0);
    EXPECT_GE(mesh.clean.triangles.rows(), 19'000);
    EXPECT_LE(mesh.clean.triangles.rows(), 30'000);
    EXPECT_LT(mesh.clean.vertices.rowwise().norm().maxCoeff(), 1.6);
    sizes.insert(mesh.clean.triangles.rows());
  }
  EXPECT_GT(sizes.size(), 2u);
}

}  // namespace
}  // namespace encage::assets
