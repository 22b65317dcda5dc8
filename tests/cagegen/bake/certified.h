// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace encage::test {

inline BakeOptions with_faces(std::vector<std::int64_t> faces, int threads = 2,
                              BakeMethod method = BakeMethod::collapse) {
  BakeOptions options;
  options.faces = std::move(faces);
  options.threads = threads;
  options.method = method;
  return options;
}

/// Proves the whole hierarchy again, from the source.
inline void expect_certified(const CageHierarchy& hierarchy, const SourceMesh& source) {
  ASSERT_FALSE(hierarchy.levels.empty());
  const TriangleMesh* inner = &source.obstacle;
  Solid solid = source.solid;
  double clearance = 1;
  ASSERT_GT(hierarchy.diagonal, 0);
  for (const CageLevel& level : hierarchy.levels) {
    EXPECT_EQ(level.mesh.vertices, level.mesh.vertices.cast<float>().cast<double>());
    const CertifyResult proof = certify(*inner, solid, level.mesh);
    ASSERT_TRUE(proof.holds) << proof.reason;
    EXPECT_EQ(proof.certificate.clearance, level.certificate.clearance);
    EXPECT_EQ(proof.certificate.genus, level.certificate.genus);
    EXPECT_EQ(proof.certificate.components, level.certificate.components);
    EXPECT_EQ(level.certificate.volume_ratio.has_value(), source.volume > 0);
    EXPECT_GT(level.certificate.volume_ratio.value_or(2), 1);
    const DistanceBounds distances = distance_bounds(source.obstacle, level.mesh);
    EXPECT_EQ(distances.max_distance, level.certificate.max_distance);
    EXPECT_EQ(distances.mean_distance, level.certificate.mean_distance);
    EXPECT_LE(level.certificate.clearance, distances.mean_distance);
    clearance = std::min(clearance, level.certificate.clearance / hierarchy.diagonal);
    inner = &level.mesh;
    solid = Solid::closed;
  }
  EXPECT_GT(clearance, 0.99e-5);
}

}  // namespace encage::test
