// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/certify/certify.h"
#include "cagegen/certify/connectivity.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

namespace encage::makers::shapes {

/// A sphere with bumps: no two triangles alike.
inline TriangleMesh bumpy_sphere(int levels, std::uint32_t seed, double height = 0.1) {
  TriangleMesh mesh = sphere(levels);
  Random random(seed);
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) mesh.vertices.row(v) *= 1 + random(-height, height);
  return mesh;
}

/// A vertex of the sphere pushed through its opposite side.
inline TriangleMesh stabbed_sphere(int levels, double depth) {
  TriangleMesh mesh = sphere(levels);
  mesh.vertices.row(0) << -1 - depth, 0, 0;
  return mesh;
}

inline void expect_manifold(const TriangleMesh& mesh, int genus, int components) {
  const proof::Connectivity c = proof::connectivity(mesh);
  EXPECT_EQ(c.defect, "");
  EXPECT_TRUE(c.closed) << c.open_edge;
  EXPECT_EQ(c.genus, genus);
  EXPECT_EQ(c.component_count, components);
}

/// By exact arithmetic.
inline bool embedded(const TriangleMesh& mesh) { return certify_alone(mesh).holds; }

}  // namespace encage::makers::shapes
