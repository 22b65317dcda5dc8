// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>

#include <CGAL/IO/OBJ.h>
#include <CGAL/IO/OFF.h>
#include <CGAL/IO/PLY.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace encage {
namespace {

using test::Folder;

/// A sphere-like mesh with coordinates that use all bits, or floats.
TriangleMesh rough_mesh(bool floats) {
  TriangleMesh mesh = test::sheet(20, [](double x, double y) { return x * y / 3; });
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> offset(-1e-3, 1e-3);
  for (double& x : mesh.vertices.reshaped()) {
    x += offset(random);
    if (floats) x = static_cast<float>(x);
  }
  return mesh;
}

/// Vertices renumbered by first use, as an STL reader has to.
TriangleMesh by_first_use(const TriangleMesh& mesh) {
  std::vector<int> number(static_cast<std::size_t>(mesh.vertices.rows()), -1);
  TriangleMesh result = mesh;
  int count = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      int& n = number[mesh.triangles(t, k)];
      if (n < 0) {
        n = count++;
        result.vertices.row(n) = mesh.vertices.row(mesh.triangles(t, k));
      }
      result.triangles(t, k) = n;
    }
  }
  return result;
}

TEST(WriteMesh, ReadsBackExactly) {
  const Folder folder;
  for (const char* name : {"a.obj", "a.off", "a.ply"}) {
    TriangleMesh mesh = rough_mesh(false);
    mesh.vertices(0, 0) = 1e300;
    mesh.vertices(1, 1) = std::numeric_limits<double>::denorm_min();
    write_mesh(folder / name, mesh);
    const TriangleMesh back = triangulate(read_polygon_mesh(folder / name));
    EXPECT_EQ(back.vertices, mesh.vertices) << name;
    EXPECT_EQ(back.triangles, mesh.triangles) << name;
  }
  const TriangleMesh mesh = by_first_use(rough_mesh(true));
  write_mesh(folder / "a.stl", mesh);
  const TriangleMesh back = triangulate(read_polygon_mesh(folder / "a.stl"));
  EXPECT_EQ(back.vertices, mesh.vertices);
  EXPECT_EQ(back.triangles, mesh.triangles);
}

/// Without the formats that CGAL::IO::read_polygon_soup() knows besides, which take seconds to compile.
template <class Points, class Polygons>
bool read_by_cgal(const std::string& file, Points& points, Polygons& polygons) {
  if (file.ends_with(".obj")) return CGAL::IO::read_OBJ(file, points, polygons);
  if (file.ends_with(".off")) return CGAL::IO::read_OFF(file, points, polygons);
  if (file.ends_with(".ply")) return CGAL::IO::read_PLY(file, points, polygons);
  return CGAL::IO::read_STL(file, points, polygons);
}

TEST(WriteMesh, CgalReadsTheSame) {
  const Folder folder;
  const TriangleMesh mesh = by_first_use(rough_mesh(true));
  for (const char* name : {"a.obj", "a.off", "a.ply", "a.stl"}) {
    write_mesh(folder / name, mesh);
    std::vector<CGAL::Simple_cartesian<double>::Point_3> points;
    std::vector<std::vector<std::size_t>> polygons;
    ASSERT_TRUE(read_by_cgal((folder / name).string(), points, polygons)) << name;
    ASSERT_EQ(static_cast<Eigen::Index>(points.size()), mesh.vertices.rows()) << name;
    ASSERT_EQ(static_cast<Eigen::Index>(polygons.size()), mesh.triangles.rows()) << name;
    for (std::size_t v = 0; v < points.size(); ++v) {
      for (int k = 0; k < 3; ++k) ASSERT_EQ(points[v][k], mesh.vertices(v, k)) << name << ' ' << v;
    }
    for (std::size_t t = 0; t < polygons.size(); ++t) {
      ASSERT_EQ(polygons[t].size(), 3u);
      for (int k = 0; k < 3; ++k) ASSERT_EQ(static_cast<int>(polygons[t][k]), mesh.triangles(t, k)) << name << ' ' << t;
    }
  }
}

TEST(WriteMesh, LeavesTheOldFileOnFailure) {
  const Folder folder;
  const std::filesystem::path file = folder.write("a.stl", "precious");
  TriangleMesh mesh = test::box();
  mesh.vertices(3, 1) = 1e300;
  try {
    write_mesh(file, mesh);
    FAIL() << "STL cannot hold 1e300";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), file.string() + ": vertex 3: STL cannot hold this coordinate");
  }
  EXPECT_EQ(test::bytes_of(file), "precious");
  // A rename onto a folder fails after everything has been written.
  std::filesystem::create_directory(folder / "b.obj");
  EXPECT_THROW(write_mesh(folder / "b.obj", test::box()), Error);
  EXPECT_TRUE(std::filesystem::is_directory(folder / "b.obj"));
  EXPECT_THROW(write_mesh(folder / "missing" / "c.obj", test::box()), Error);
  EXPECT_EQ(folder.file_count(), 2u) << "a temporary was left behind";
}

TEST(WriteMesh, RefusesUnknownExtensions) {
  const Folder folder;
  EXPECT_THROW(write_mesh(folder / "a.glb", test::box()), Error);
  EXPECT_THROW(write_mesh(folder / "a", test::box()), Error);
  EXPECT_EQ(folder.file_count(), 0u);
}

}  // namespace
}  // namespace encage
