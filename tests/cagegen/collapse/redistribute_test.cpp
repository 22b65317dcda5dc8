// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/redistribute.h"

#include "cagegen/collapse/collapse.h"
#include "cagegen/collapse/starts.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

namespace encage::makers {
namespace {

constexpr double cage_clearance = 1e-4;

RedistributeRequest request_for(std::int64_t faces) {
  RedistributeRequest request;
  request.editing.clearance = request.editing.self_clearance = cage_clearance;
  request.contact.clearance = request.contact.self_clearance = cage_clearance;
  request.faces = faces;
  request.rounds = 3;
  request.work = 1'000'000'000;
  return request;
}

/// A ball with a thin spike: faces are needed at the spike.
TriangleMesh spiked_ball() {
  TriangleMesh mesh = shapes::sphere(4);
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const double x = mesh.vertices(v, 0);
    if (x > 0.95) mesh.vertices(v, 0) = 0.95 + 40 * (x - 0.95);
  }
  return mesh;
}

TEST(Redistribute, SavesVolumeAndKeepsTheCage) {
  for (const TriangleMesh& mesh : {spiked_ball(), shapes::torus(1, 0.3, 40, 20)}) {
    const Obstacle obstacle(mesh);
    const auto start = offset_start(obstacle, mesh, 0.01, false, cage_clearance);
    ASSERT_TRUE(start);
    const RedistributeRequest request = request_for(80);
    CageEditor editor(obstacle, *start, request.editing);
    CollapseLimits limits;
    limits.faces = request.faces;
    ASSERT_TRUE(collapse_edges(editor, limits));
    const TriangleMesh cage = shrink(obstacle, editor.extract(), request.contact);
    const TriangleMesh better = redistribute_faces(obstacle, cage, request);
    EXPECT_LE(better.triangles.rows(), request.faces);
    const double volume = signed_volume(mesh);
    EXPECT_LT(signed_volume(better) - volume, 0.97 * (signed_volume(cage) - volume));
    const CertifyResult proof = certify(mesh, Solid::closed, better);
    EXPECT_TRUE(proof.holds) << proof.reason;
    EXPECT_GE(proof.certificate.clearance, cage_clearance * (1 - 1e-6));
    EXPECT_EQ(better.vertices, redistribute_faces(obstacle, cage, request).vertices) << "the same every time";
  }
}

TEST(Redistribute, WhatCannotBeBetterStays) {
  const TriangleMesh mesh = shapes::cube(1);
  const Obstacle obstacle(mesh);
  const auto cage = offset_start(obstacle, mesh, 2e-4, false, cage_clearance);
  ASSERT_TRUE(cage);
  const TriangleMesh same = redistribute_faces(obstacle, *cage, request_for(12));
  EXPECT_LE(signed_volume(same), signed_volume(*cage));
  EXPECT_EQ(same.triangles.rows(), 12);
}

}  // namespace
}  // namespace encage::makers
