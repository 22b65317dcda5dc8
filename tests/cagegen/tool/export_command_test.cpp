// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/tool/command_fixture.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <string>

namespace encage::test {
namespace {

class ExportCommand : public CommandTest {
 protected:
  TriangleMesh exported(const std::string& level, const std::string& file) {
    const RunResult result = encage({"export", "model.glb", "--level", level, "-o", file});
    EXPECT_EQ(result.status, 0) << result.err;
    return triangulate(read_polygon_mesh(folder.path() / file));
  }
};

TEST_F(ExportCommand, RoundTripsThroughEveryFormat) {
  // Far from 0, so that the file has an origin of its own.
  TriangleMesh mesh = torus(24, 12);
  mesh.vertices.col(0).array() += 4096;
  folder.write("model.obj", to_obj(mesh));
  write_rings(4096);
  ASSERT_EQ(encage({"bake", "model.obj", "--coarse", "fine.off,coarse.off"}).status, 0);
  const CageHierarchy hierarchy = read_asset(folder.path() / "model.glb");
  ASSERT_NE(hierarchy.origin.x(), 0);
  TriangleMesh cage = hierarchy.levels[1].mesh;
  cage.vertices.rowwise() += hierarchy.origin.transpose();
  for (const char* file : {"cage.obj", "cage.off", "cage.ply"}) {
    const TriangleMesh back = exported("2", file);
    EXPECT_EQ(back.triangles, cage.triangles) << file;
    EXPECT_EQ(back.vertices, cage.vertices) << file;
  }
  // STL repeats vertices and may hold float32.
  const TriangleMesh back = exported("2", "cage.stl");
  ASSERT_EQ(back.triangles.rows(), cage.triangles.rows());
  for (std::int64_t t = 0; t < cage.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((back.corner(t, k) - cage.corner(t, k)).norm(), 1e-3);
  }
}

TEST_F(ExportCommand, LevelZeroIsTheSource) {
  bake_model();
  const TriangleMesh source = torus(24, 12);
  const TriangleMesh back = exported("0", "source.off");
  EXPECT_EQ(back.triangles, source.triangles);
  EXPECT_LT((back.vertices - source.vertices).cwiseAbs().maxCoeff(), 1e-6);
}

TEST_F(ExportCommand, BadRequestsAreRefused) {
  bake_model();
  expect_refused({"export", "model.glb", "--level", "3", "-o", "a.obj"}, "level 3");
  expect_refused({"export", "model.glb", "--level", "-1", "-o", "a.obj"}, "--level");
  expect_refused({"export", "model.glb", "-o", "a.obj"}, "--level");
  expect_refused({"export", "model.glb", "--level", "1"}, "--output");
  expect_refused({"export", "model.glb", "--level", "1", "-o", "a.xyz"}, "a.xyz");
  expect_refused({"export", "model.glb", "--level", "1", "-o", "nowhere/a.obj"}, "nowhere");
  expect_refused({"export", "model.glb", "--level", "1", "-o", "model.glb"}, "model.glb");
  expect_refused({"export", "missing.glb", "--level", "1", "-o", "a.obj"}, "missing.glb");
  write_rings();
  ASSERT_EQ(encage({"bake", "model.obj", "--coarse", "fine.off", "--no-source"}).status, 0);
  expect_refused({"export", "model.glb", "--level", "0", "-o", "a.obj"}, "not stored");
}

}  // namespace
}  // namespace encage::test
