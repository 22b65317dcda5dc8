// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/handmade/shapes.h"
#include "bench/suite/handmade/solid_mesh.h"
#include "src/mesh/rounding.h"

#include <encage/bake.h>
#include <encage/error.h>

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

namespace encage::handmade {
namespace {

TEST(Plate, HasTheVolumeOfItsParts) {
  const Loop square = rectangle(0, 0, 4, 3);
  EXPECT_DOUBLE_EQ(signed_volume(plate(square, 1, 2)), 12);
  EXPECT_EQ(plate(square, 1, 2).triangles.rows(), 12);
  const std::vector<Recess> recesses = {{rectangle(0.5, 0.5, 1, 1), 1.25},  // a pocket
                                        {rectangle(2, 0.5, 3, 1), 1},       // a hole
                                        {rectangle(2, 2, 3, 2.5), 4}};      // a leg
  const TriangleMesh mesh = plate(square, 1, 2, recesses);
  EXPECT_TRUE(is_closed(mesh));
  EXPECT_NEAR(signed_volume(mesh), 12 - 0.25 * 0.75 - 0.5 + 0.5 * 2, 1e-12);
  // Concave outlines, and corners in one line.
  const Loop bend = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  EXPECT_NEAR(signed_volume(plate(bend, 0, 1)), 3, 1e-12);
  EXPECT_THROW(plate(square, 0, 1, {{rectangle(5, 5, 6, 6), 0.5}}), Error);
}

TEST(Refined, SplitsEdgesAndKeepsTheSurface) {
  const TriangleMesh coarse = plate(rectangle(0, 0, 2, 1), 0, 0.1, {{rectangle(0.5, 0.25, 1, 0.5), 0}});
  const TriangleMesh fine = refined(coarse, 0.15);
  EXPECT_TRUE(is_closed(fine));
  EXPECT_NEAR(signed_volume(fine), signed_volume(coarse), 1e-12);
  for (Eigen::Index t = 0; t < fine.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LE((fine.corner(t, k) - fine.corner(t, (k + 1) % 3)).norm(), 0.15);
  }
}

TEST(Subjects, HandmadeCagesAreCertified) {
  const std::vector<Subject> all = subjects();
  ASSERT_EQ(all.size(), 11U);
  std::set<std::string> names;
  for (const Subject& subject : all) {
    names.insert(subject.name);
    const SourceMesh source = sanitize(subject.mesh);
    if (subject.cage.triangles.rows() == 0) {
      EXPECT_EQ(subject.name, "leaf cards");
      EXPECT_EQ(source.solid, Solid::surface_only);
      EXPECT_EQ(source.report.duplicate_triangles, 0);
      continue;
    }
    EXPECT_EQ(source.solid, Solid::closed) << subject.name;
    EXPECT_EQ(source.report.flipped_components, 0) << subject.name;
    EXPECT_GT(subject.mesh.triangles.rows(), 1000) << subject.name;
    EXPECT_LE(subject.cage.triangles.rows(), 108) << subject.name;
    TriangleMesh cage = subject.cage;
    cage.vertices.rowwise() -= source.origin.transpose();
    round_vertices(cage);
    const CertifyResult proof = certify(source.obstacle, source.solid, cage);
    EXPECT_TRUE(proof.holds) << subject.name << ": " << proof.reason;
    EXPECT_EQ(proof.certificate.components, subject.name == "chain" ? 3 : 1);
  }
  EXPECT_EQ(names.size(), all.size());
}

}  // namespace
}  // namespace encage::handmade
