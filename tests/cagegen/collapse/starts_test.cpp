// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/collapse/starts.h"

#include "cagegen/certify/connectivity.h"
#include "cagegen/collapse/convex_starts.h"
#include "tests/cagegen/geometry/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <thread>
#include <vector>

namespace encage::makers {
namespace {

using shapes::joined;
using shapes::moved;
using shapes::scaled;
using shapes::sphere;

/// Proven by exact arithmetic to be a cage around the mesh.
Certificate expect_cage(const TriangleMesh& inner, Solid solid, const TriangleMesh& cage, double clearance) {
  const CertifyResult proof = certify(inner, solid, cage);
  EXPECT_TRUE(proof.holds) << proof.reason;
  EXPECT_GE(proof.certificate.clearance, clearance * (1 - 1e-6));
  EXPECT_EQ(cage.vertices, shapes::rounded(cage).vertices);
  EXPECT_TRUE(clear(Obstacle(inner), cage, clearance));
  return proof.certificate;
}

TEST(OffsetStart, MovesASurfaceOutward) {
  for (const TriangleMesh& solid : {sphere(3), shapes::torus(1, 0.4, 30, 16), shapes::cube(1)}) {
    for (const double height : {1e-4, 0.02}) {
      const auto cage = offset_start(Obstacle(solid), solid, height, false, 1e-5);
      ASSERT_TRUE(cage);
      const Certificate certificate = expect_cage(solid, Solid::closed, *cage, 1e-5);
      EXPECT_NEAR(certificate.clearance, height, 0.01 * height + 1e-6) << "every triangle's plane moves by the height";
      EXPECT_EQ(certificate.no_new_handles, true);
    }
  }
}

TEST(OffsetStart, LessWhereTheSurfaceIsNearItself) {
  // Two cubes 0.02 apart: a height of 0.02 each is too much in between.
  const TriangleMesh solid = joined(shapes::cube(1), shapes::cube(1, {2.02, 0, 0}));
  const auto cage = offset_start(Obstacle(solid), solid, 0.02, false, 1e-5);
  ASSERT_TRUE(cage);
  EXPECT_EQ(expect_cage(solid, Solid::closed, *cage, 1e-5).components, 2);
}

TEST(OffsetStart, LeavesSharpSaddles) {
  // The top is z = 4 (|x| - |y|): the middle has to rise by sqrt(1 + 2 * 4^2) for its planes to rise by one.
  constexpr double slope = 4;
  std::vector<std::array<double, 3>> points;
  for (const double z : {0.0, -3 * slope}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double x : {-1.0, 0.0, 1.0}) {
        points.push_back({x, y, z == 0 ? slope * (std::abs(x) - std::abs(y)) : z});
      }
    }
  }
  std::vector<std::array<int, 3>> triangles;
  const auto quad = [&](int a, int b, int c, int d) {
    triangles.push_back({a, b, c});
    triangles.push_back({a, c, d});
  };
  const std::array<int, 9> rim = {0, 1, 2, 5, 8, 7, 6, 3, 0};
  for (const int v : {0, 1, 3, 4}) {
    quad(v, v + 1, v + 4, v + 3);
    quad(v + 9, v + 12, v + 13, v + 10);
  }
  for (std::size_t i = 0; i + 1 < rim.size(); ++i) quad(rim[i], rim[i] + 9, rim[i + 1] + 9, rim[i + 1]);
  const TriangleMesh solid = shapes::mesh(points, triangles);
  ASSERT_GT(signed_volume(solid), 0);
  const auto cage = offset_start(Obstacle(solid), solid, 1e-3, false, 1e-5);
  ASSERT_TRUE(cage);
  expect_cage(solid, Solid::closed, *cage, 1e-5);
}

TEST(OffsetStart, GrowsFromADecimation) {
  for (const TriangleMesh& solid : {sphere(5), shapes::torus(1, 0.4, 80, 40)}) {
    const auto cage = offset_start(Obstacle(solid), simplify(solid, 400), 1e-3, true, 1e-5);
    ASSERT_TRUE(cage);
    expect_cage(solid, Solid::closed, *cage, 1e-5);
    EXPECT_LE(cage->triangles.rows(), 400);
    EXPECT_LT(signed_volume(*cage), 1.3 * signed_volume(solid));
  }
}

TEST(OffsetStart, GivesUpOnSurfacesThatIntersectThemselves) {
  const TriangleMesh crossing = joined(shapes::cube(1), shapes::cube(1, {0.5, 0.5, 0.5}));
  EXPECT_FALSE(offset_start(Obstacle(crossing), crossing, 1e-3, false, 1e-5));
}

TEST(WrapStart, WrapsAnything) {
  shapes::Random random(71);
  TriangleMesh soup = shapes::mesh({}, {});
  for (int i = 0; i < 12; ++i) soup = shapes::with_triangle(soup, random.point(1), random.point(1), random.point(1));
  TriangleMesh open = sphere(2);
  open.triangles.conservativeResize(100, 3);
  int made = 0;
  for (const TriangleMesh& mesh :
       {soup, open, sphere(2), shapes::with_triangle(shapes::mesh({}, {}), {0, 0, 0}, {1, 0, 0}, {0, 1, 1})}) {
    const auto cage = wrap_start(Obstacle(mesh), mesh, 0.4, 0.04, 1e-5);
    if (!cage) continue;  // it may fail, but not lie
    ++made;
    expect_cage(mesh, Solid::surface_only, *cage, 1e-5);
  }
  EXPECT_GE(made, 2);
}

TEST(WrapStart, TheSameInEveryThread) {
  const TriangleMesh mesh = shapes::torus(1, 0.4, 24, 12);
  const Obstacle obstacle(mesh);
  const auto wrap = [&] { return wrap_start(obstacle, mesh, 0.3, 0.03, 1e-5); };
  const auto first = wrap();
  ASSERT_TRUE(first);
  for (int i = 0; i < 3; ++i) {
    std::optional<TriangleMesh> again;
    std::thread([&] { again = wrap(); }).join();
    ASSERT_TRUE(again);
    EXPECT_EQ(first->vertices, again->vertices);
    EXPECT_EQ(first->triangles, again->triangles);
  }
}

TEST(ConvexStarts, EncloseAnything) {
  const auto triangle = [](const Point& a, const Point& b, const Point& c) {
    return shapes::with_triangle(shapes::mesh({}, {}), a, b, c);
  };
  TriangleMesh sheet = shapes::mesh({}, {});
  TriangleMesh needle = sheet;
  for (int i = 0; i < 20; ++i) {
    const double x = i;
    sheet = shapes::with_triangle(sheet, {x, 0, x}, {x + 1, 0, x + 1}, {x, 20, x + 10});  // y = 2 (z - x)
    needle = shapes::with_triangle(needle, {x, 2 * x, 3 * x}, {x + 1, 2 * x + 2, 3 * x + 3},
                                   {x + 1, 2 * x + 2, 3 * x + 3 + 1e-6});
  }
  const std::vector<TriangleMesh> meshes = {sphere(3),
                                            shapes::tetrahedron(1),
                                            shapes::tetrahedron(1, {9, 9, 9}),
                                            triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                                            triangle({1, 0, 0}, {0, 1, 0}, {0, 0, 1}),
                                            triangle({1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 1e-9}),
                                            triangle({0, 0, 0}, {1, 2, 3}, {2, 4, 6}),
                                            triangle({1, 1, 1}, {1, 1, 2}, {1, 1, 2}),
                                            sheet,
                                            needle,
                                            joined(sphere(1), moved(sphere(1), {100, 50, 20})),
                                            shapes::torus(1, 0.2, 20, 10)};
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    SCOPED_TRACE(i);
    const TriangleMesh& mesh = meshes[i];
    const double diagonal = bounds(mesh).diagonal().norm();
    for (const double clearance : {1e-5, 0.03, 0.09}) {
      const Obstacle obstacle(mesh);
      const ConvexFrame frame(mesh, clearance * diagonal);
      const TriangleMesh hull = hull_start(obstacle, frame, clearance * diagonal);
      const Certificate certificate = expect_cage(mesh, Solid::surface_only, hull, clearance * diagonal);
      EXPECT_EQ(certificate.components, 1);
      EXPECT_EQ(certificate.genus, 0);
      const TriangleMesh again = hull_start(obstacle, frame, clearance * diagonal);
      EXPECT_EQ(hull.vertices, again.vertices);
      EXPECT_EQ(hull.triangles, again.triangles);
      const TriangleMesh box = box_start(obstacle, frame, clearance * diagonal);
      EXPECT_EQ(box.triangles.rows(), 12);
      expect_cage(mesh, Solid::surface_only, box, clearance * diagonal);
      EXPECT_EQ(box.vertices, box_start(obstacle, frame, clearance * diagonal).vertices);
      const TriangleMesh tetrahedron = tetrahedron_start(obstacle, frame, clearance * diagonal);
      EXPECT_EQ(tetrahedron.triangles.rows(), 4);
      expect_cage(mesh, Solid::surface_only, tetrahedron, clearance * diagonal);
    }
  }
  EXPECT_LT(signed_volume(hull_start(Obstacle(meshes[0]), ConvexFrame(meshes[0], 1e-5), 1e-5)),
            1.01 * signed_volume(meshes[0]));
  EXPECT_LT(signed_volume(hull_start(Obstacle(meshes[1]), ConvexFrame(meshes[1], 1e-5), 1e-5)), 1.01 / 6)
      << "the box's middle is outside";
}

void expect_manifold(const TriangleMesh& mesh) {
  EXPECT_EQ(proof::connectivity(mesh).defect, "");
  EXPECT_TRUE(is_closed(mesh));
}

TEST(MakeManifold, PullsPartsAtAnEdgeOrAVertexApart) {
  // Two tetrahedra on vertices 0..3 and 0, 4..: sharing one vertex, then an edge.
  const TriangleMesh at_vertex =
      shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                   {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 4, 5}, {0, 6, 4}, {4, 6, 5}, {0, 5, 6}});
  const TriangleMesh at_edge =
      shapes::mesh({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0.5, 1, 0}, {-1, 0, 0}, {-0.5, -1, 0}},
                   {{0, 3, 2}, {0, 2, 1}, {2, 3, 1}, {0, 1, 3}, {0, 5, 4}, {0, 4, 1}, {4, 5, 1}, {0, 1, 5}});
  for (const TriangleMesh& mesh : {at_vertex, at_edge}) {
    ASSERT_NE(proof::connectivity(mesh).defect, "");
    const TriangleMesh split = make_manifold(mesh);
    expect_manifold(split);
    EXPECT_EQ(split.triangles.rows(), 8);
    EXPECT_EQ(split.vertices.rows(), 8);
    std::vector<std::int32_t> label;
    EXPECT_EQ(triangle_components(split, label), 2);
    EXPECT_NEAR(signed_volume(split), signed_volume(mesh), 1e-12);
  }
}

TEST(MakeManifold, DropsPairsOfOppositeTriangles) {
  TriangleMesh mesh = shapes::tetrahedron(1);
  mesh.vertices.conservativeResize(7, 3);
  mesh.vertices.bottomRows(3) << 5, 5, 5, 6, 5, 5, 5, 6, 5;
  mesh.triangles.conservativeResize(6, 3);
  mesh.triangles.bottomRows(2) << 4, 5, 6, 6, 5, 4;
  const TriangleMesh kept = make_manifold(mesh);
  expect_manifold(kept);
  EXPECT_EQ(kept.triangles.rows(), 4);
  EXPECT_EQ(kept.vertices.rows(), 4) << "unused vertices go";
  const TriangleMesh same = make_manifold(shapes::cube(1));
  expect_manifold(same);
  EXPECT_EQ(same.triangles.rows(), 12);
}

TEST(Simplify, ToAFewManifoldFaces) {
  for (const double size : {1e-20, 1.0, 1e20}) {
    const TriangleMesh coarse = simplify(scaled(moved(sphere(5), {30, 20, 10}), size), 300);
    expect_manifold(coarse);
    EXPECT_LE(coarse.triangles.rows(), 300);
    EXPECT_GT(coarse.triangles.rows(), 200);
    EXPECT_NEAR(signed_volume(coarse) / (size * size * size), 4.1, 0.3);
  }
  EXPECT_EQ(simplify(sphere(1), 100).triangles.rows(), 32) << "few enough already";
}

TEST(OutermostComponents, DropsCavitiesAndWhatLiesInside) {
  const TriangleMesh ball = sphere(2);
  const auto count = [](const TriangleMesh& mesh) {
    std::vector<std::int32_t> label;
    return triangle_components(outermost_components(mesh), label);
  };
  EXPECT_EQ(count(ball), 1);
  EXPECT_EQ(count(joined(ball, moved(ball, {3, 0, 0}))), 2);
  const TriangleMesh cavity = shapes::flipped(scaled(ball, 0.7));
  EXPECT_EQ(count(joined(ball, cavity)), 1);
  EXPECT_EQ(count(joined(ball, scaled(ball, 0.7))), 1) << "a ball in a ball";
  EXPECT_EQ(count(joined(joined(ball, cavity), scaled(ball, 0.3))), 1) << "a ball in a cavity";
  EXPECT_EQ(count(joined(joined(scaled(ball, 0.3), cavity), joined(ball, moved(ball, {9, 0, 0})))), 2) << "any order";
  // In the hole of a torus, and in its box only: not inside.
  EXPECT_EQ(count(joined(shapes::torus(2, 0.5, 24, 12), ball)), 2);
  const TriangleMesh kept = outermost_components(joined(scaled(ball, 0.3), ball));
  EXPECT_EQ(kept.vertices.rows(), ball.vertices.rows());
  EXPECT_EQ(kept.triangles.rows(), ball.triangles.rows());
  EXPECT_DOUBLE_EQ(signed_volume(kept), signed_volume(ball));
}

TEST(Clear, SeesTheObstacleAndTheCageItself) {
  const Obstacle obstacle(shapes::cube(1));
  EXPECT_TRUE(clear(obstacle, shapes::cube(1.1), 0.05));
  EXPECT_FALSE(clear(obstacle, shapes::cube(1.1), 0.15));
  EXPECT_FALSE(clear(obstacle, shapes::cube(1), 1e-6));
  EXPECT_FALSE(clear(obstacle, joined(shapes::cube(2), shapes::cube(2, {1, 1, 1})), 1e-6));
  TriangleMesh thin = shapes::cube(2);
  thin.vertices.row(1) = thin.vertices.row(0);
  EXPECT_FALSE(clear(obstacle, thin, 1e-6)) << "degenerate triangles";
}

}  // namespace
}  // namespace encage::makers
