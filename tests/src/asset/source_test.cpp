// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/files/hash.h"
#include "tests/src/asset/forge.h"
#include "tests/src/asset/sample.h"

#include <encage/asset.h>

#include <gtest/gtest.h>

#include <string>

namespace encage {
namespace {

/// The ten triangles of the sample that are not caps, where the source has them.
TriangleMesh source_of(const CageHierarchy& hierarchy) {
  TriangleMesh mesh = hierarchy.fine;
  mesh.vertices.rowwise() += hierarchy.origin.transpose();
  mesh.triangles.conservativeResize(mesh.triangles.rows() - hierarchy.cap_count, 3);
  return mesh;
}

class Source : public testing::Test {
 protected:
  Source() : hierarchy(sample_hierarchy()), mesh(source_of(hierarchy)) {
    hierarchy.source_hash = hash_mesh(mesh);
    write_asset(file.path(), hierarchy);
  }

  std::string refusal() const {
    try {
      require_source(file.path(), mesh);
    } catch (const Error& error) {
      return error.what();
    }
    return {};
  }

  TemporaryFile file;
  CageHierarchy hierarchy;
  TriangleMesh mesh;
};

TEST_F(Source, ItselfIsAccepted) { EXPECT_EQ(refusal(), ""); }

TEST_F(Source, RoundedToFloatIsAccepted) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>();
  EXPECT_NE(hash_mesh(mesh), hierarchy.source_hash);
  EXPECT_EQ(refusal(), "");
}

TEST_F(Source, WithSplitVerticesIsAccepted) {
  TriangleMesh split;
  split.vertices.resize(3 * mesh.triangles.rows(), 3);
  split.triangles.resize(mesh.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      split.vertices.row(3 * t + k) = mesh.corner(t, k).transpose();
      split.triangles(t, k) = static_cast<std::int32_t>(3 * t + k);
    }
  }
  mesh = split;
  EXPECT_EQ(refusal(), "");
}

TEST_F(Source, OfAnotherSizeIsRefusedByName) {
  mesh.triangles.conservativeResize(9, 3);
  EXPECT_NE(refusal().find(file.path().string()), std::string::npos) << refusal();
  EXPECT_NE(refusal().find("it has 9 triangles, the asset 10"), std::string::npos) << refusal();
  EXPECT_NE(refusal().find(to_string(hash_mesh(mesh))), std::string::npos) << refusal();
}

TEST_F(Source, ThatWasMovedIsRefused) {
  mesh.vertices.col(2).array() += 0.01;
  EXPECT_NE(refusal().find("triangle 0 lies elsewhere"), std::string::npos) << refusal();
}

TEST_F(Source, WithAnIndexOutOfRangeIsRefused) {
  mesh.triangles(3, 1) = 8;
  EXPECT_NE(refusal().find("out of range (8 vertices)"), std::string::npos) << refusal();
}

TEST_F(Source, OfAnAssetWithoutFineMeshNeedsTheSameHash) {
  hierarchy.fine = {};
  hierarchy.cap_count = 0;
  write_asset(file.path(), hierarchy);
  EXPECT_EQ(refusal(), "");
  mesh.vertices(0, 0) += 1e-9;
  EXPECT_NE(refusal().find("no fine mesh"), std::string::npos) << refusal();
}

}  // namespace
}  // namespace encage
