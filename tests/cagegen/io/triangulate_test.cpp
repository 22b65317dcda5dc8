// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace encage {
namespace {

PolygonMesh polygon(const std::vector<Eigen::Vector3d>& points) {
  PolygonMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v) {
    mesh.vertices.row(v) = points[v].transpose();
    mesh.corners.push_back(static_cast<std::int32_t>(v));
  }
  mesh.first.push_back(static_cast<std::int64_t>(points.size()));
  return mesh;
}

Eigen::Vector3d vector_area(const TriangleMesh& mesh, std::int64_t t) {
  return (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)) / 2;
}

/// Sum of the areas: equal to the polygon's only if no triangle is turned over.
double total_area(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) sum += vector_area(mesh, t).norm();
  return sum;
}

TEST(Triangulate, FansConvexPolygons) {
  const TriangleMesh mesh = triangulate(polygon({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {2, 2, 0}, {0, 2, 0}}));
  EXPECT_EQ(mesh.triangles, (Triangles(3, 3) << 0, 1, 2, 0, 2, 3, 0, 3, 4).finished());
}

TEST(Triangulate, SplitsADartInside) {
  // Vertex 1 is reflex: only the diagonal through it lies inside.
  const TriangleMesh mesh = triangulate(polygon({{0, 0, 1}, {1, 1, 1}, {2, 0, 1}, {1, 3, 1}}));
  ASSERT_EQ(mesh.triangles.rows(), 2);
  EXPECT_DOUBLE_EQ(total_area(mesh), 2);
  for (int t = 0; t < 2; ++t) EXPECT_GT(vector_area(mesh, t).z(), 0);
}

TEST(Triangulate, KeepsTheAreaOfCombs) {
  // Teeth along x, in a plane that leans, clockwise and counter-clockwise.
  constexpr int teeth = 50;
  std::vector<Eigen::Vector3d> points = {{0, -1, 0}, {teeth, -1, 0}};
  for (int i = teeth; i > 0; --i) {
    points.emplace_back(i, 10, 0);
    points.emplace_back(i - 0.5, 0, 0);
  }
  points.emplace_back(0, 10, 0);
  const double area = [&] {
    double twice = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d &a = points[i], &b = points[(i + 1) % points.size()];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return twice / 2;
  }();
  for (Eigen::Vector3d& p : points) p = Eigen::Vector3d(p.x(), p.y(), p.x() / 2 + 4 * p.y());  // exact
  for (const bool reversed : {false, true}) {
    if (reversed) std::reverse(points.begin(), points.end());
    const TriangleMesh mesh = triangulate(polygon(points));
    EXPECT_EQ(mesh.triangles.rows(), static_cast<Eigen::Index>(points.size()) - 2);
    double projected = 0;
    for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) projected += std::abs(vector_area(mesh, t).z());
    EXPECT_NEAR(projected, area, 1e-9);
  }
}

TEST(Triangulate, MakesNoDegenerateTrianglesAtStraightCorners) {
  const TriangleMesh mesh =
      triangulate(polygon({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}}));
  EXPECT_DOUBLE_EQ(total_area(mesh), 4);
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) EXPECT_GT(vector_area(mesh, t).z(), 0) << t;
}

/// Every side of the triangulation is either a side of the polygon, once, or a chord, once in each direction, whatever
/// the polygon looks like: a closed mesh stays closed.
TEST(Triangulate, KeepsTheBorderOfAnyPolygon) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> coordinate(0, 3);
  for (int round = 0; round < 500; ++round) {
    std::vector<Eigen::Vector3d> points(3 + round % 9);
    for (Eigen::Vector3d& p : points) p = Eigen::Vector3d(coordinate(random), coordinate(random), coordinate(random));
    const auto n = static_cast<std::int32_t>(points.size());
    const TriangleMesh mesh = triangulate(polygon(points));
    ASSERT_EQ(mesh.triangles.rows(), n - 2);
    Eigen::MatrixXi net = Eigen::MatrixXi::Zero(n, n);
    for (std::int64_t t = 0; t < n - 2; ++t) {
      for (int k = 0; k < 3; ++k) ++net(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3));
    }
    for (std::int32_t i = 0; i < n; ++i) {
      for (std::int32_t j = 0; j < n; ++j) ASSERT_EQ(net(i, j) - net(j, i), (j == (i + 1) % n) - (i == (j + 1) % n));
    }
  }
}

TEST(Triangulate, RefusesPolygonsWithTwoCorners) { EXPECT_THROW(triangulate(polygon({{0, 0, 0}, {1, 0, 0}})), Error); }

}  // namespace
}  // namespace encage
