// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/surface.h"

#include "tests/cagegen/render/shapes.h"

#include <gtest/gtest.h>

namespace encage::render {
namespace {

TEST(CornerNormals, SmoothOnASphere) {
  const TriangleMesh mesh = test::sphere(2, 4);
  const auto normals = corner_normals(mesh, true);
  ASSERT_EQ(normals.size(), static_cast<std::size_t>(mesh.triangles.rows()) * 3);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(normals[3 * t + k].dot(mesh.corner(t, k).normalized().cast<float>()), 0.998F);
    }
  }
}

TEST(CornerNormals, CreasesOfACubeStaySharp) {
  const TriangleMesh mesh = test::cube(1);
  const auto smooth = corner_normals(mesh, true), flat = corner_normals(mesh, false);
  for (std::size_t i = 0; i < flat.size(); ++i) EXPECT_LT((smooth[i] - flat[i]).norm(), 1e-6F);
}

TEST(CornerNormals, CornersAtOnePlaceCountAsOne) {
  const TriangleMesh welded = test::sphere(1, 3);
  TriangleMesh soup;
  soup.vertices.resize(welded.triangles.size(), 3);
  soup.triangles.resize(welded.triangles.rows(), 3);
  for (std::int32_t i = 0; i < welded.triangles.size(); ++i) {
    soup.vertices.row(i) = welded.vertices.row(welded.triangles.data()[i]);
    soup.triangles.data()[i] = i;
  }
  const auto a = corner_normals(welded, true), b = corner_normals(soup, true);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT((a[i] - b[i]).norm(), 1e-5F);
}

TEST(Scene, FindsTheNearestItem) {
  const TriangleMesh inner = test::cube(1), outer = test::cube(2);
  std::vector<Item> items(2);
  items[0].mesh = &inner;
  items[1].mesh = &outer;
  const Scene both(items, {0, 1}, Eigen::Vector3d::Zero());
  const Scene only_inner(items, {0}, Eigen::Vector3d::Zero());
  const Ray ray{{5, 0.3, 0.2}, {-1, 0, 0}, 0, 100};
  const auto hit = both.nearest(ray);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->item, 1U);
  EXPECT_NEAR(hit->distance, 3, 1e-5);
  const auto inner_hit = only_inner.nearest(ray);
  ASSERT_TRUE(inner_hit);
  EXPECT_EQ(inner_hit->item, 0U);
  EXPECT_NEAR(inner_hit->distance, 4, 1e-5);
  EXPECT_TRUE(both.blocked(ray));
  EXPECT_FALSE(both.blocked({{5, 0.3, 0.2}, {1, 0, 0}, 0, 100}));
  EXPECT_FALSE(both.blocked({{5, 0.3, 0.2}, {-1, 0, 0}, 0, 2.5}));
}

TEST(Scene, IsExactFarFromZero) {
  const Eigen::Vector3d far(1e6, -2e6, 3e6);
  TriangleMesh mesh = test::cube(1e-2);
  mesh.vertices.rowwise() += far.transpose();
  std::vector<Item> items(1);
  items[0].mesh = &mesh;
  const Scene scene(items, {0}, far);
  const auto hit = scene.nearest({far + Eigen::Vector3d(1, 0.001, 0.002), {-1, 0, 0}, 0, 100});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 0.99, 1e-6);
}

}  // namespace
}  // namespace encage::render
