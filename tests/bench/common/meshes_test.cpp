// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/meshes.h"

#include "oracles/sample_shapes.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <string>

namespace encage::bench {
namespace {

TEST(FineMesh, IsTheAssetsInTheBodyFrame) {
  for (test::Sample& sample : test::sample_shapes(0)) {
    sample.hierarchy.origin = {5, -2, 1};
    const TriangleMesh mesh = fine_mesh(*make_shape(sample.hierarchy), "a.glb");
    const TriangleMesh expected = in_body_frame(sample.hierarchy.fine, sample.hierarchy.origin);
    EXPECT_EQ(mesh.triangles, expected.triangles) << sample.name;
    EXPECT_EQ(mesh.vertices, expected.vertices) << sample.name;
  }
}

TEST(FineMesh, NamesTheFileThatLacksIt) {
  const ShapePtr shape = make_shape(test::without_fine(test::sample_shapes(0).front()).hierarchy);
  try {
    fine_mesh(*shape, "cages.glb");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), "cages.glb: holds no fine mesh");
  }
}

}  // namespace
}  // namespace encage::bench
