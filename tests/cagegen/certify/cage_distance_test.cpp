// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/meshes.h"

#include <encage/bake.h>
#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace encage {
namespace {

using shapes::cube;

/// The distance of a point from a triangle as the least over its plane's foot, if that is inside, and its edges.
double point_triangle(const Eigen::Vector3d& p, const TriangleMesh& mesh, std::int64_t t) {
  double least = std::numeric_limits<double>::infinity();
  Eigen::Matrix<double, 3, 2> sides;
  sides << mesh.corner(t, 1) - mesh.corner(t, 0), mesh.corner(t, 2) - mesh.corner(t, 0);
  const Eigen::Vector2d weights = sides.colPivHouseholderQr().solve(p - mesh.corner(t, 0));
  if (weights.minCoeff() >= 0 && weights.sum() <= 1) least = (p - mesh.corner(t, 0) - sides * weights).norm();
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d a = mesh.corner(t, k);
    const Eigen::Vector3d along = mesh.corner(t, (k + 1) % 3) - a;
    const double length2 = along.squaredNorm();
    const double s = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0;
    least = std::min(least, (p - a - s * along).norm());
  }
  return least;
}

double distance(const Eigen::Vector3d& p, const TriangleMesh& surface) {
  double least = std::numeric_limits<double>::infinity();
  for (std::int64_t t = 0; t < surface.triangles.rows(); ++t) least = std::min(least, point_triangle(p, surface, t));
  return least;
}

/// The largest and the mean distance of the vertices and of n^2 points of each triangle of the cage, by all pairs.
DistanceBounds sampled(const TriangleMesh& surface, const TriangleMesh& cage, int n) {
  DistanceBounds result;
  double area_sum = 0;
  for (std::int64_t t = 0; t < cage.triangles.rows(); ++t) {
    const Eigen::Vector3d a = cage.corner(t, 0), u = cage.corner(t, 1) - a, v = cage.corner(t, 2) - a;
    double sum = 0;
    // Centroids of n^2 equal parts: n (n + 1) / 2 that point one way, and between them those that point the other way.
    for (const double third : {1 / 3.0, 2 / 3.0}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j + 3 * third < n + 1; ++j) {
          const double d = distance(a + (i + third) / n * u + (j + third) / n * v, surface);
          sum += d;
          result.max_distance = std::max(result.max_distance, d);
        }
      }
    }
    const double area = u.cross(v).norm();
    result.mean_distance += area * sum / (n * n);
    area_sum += area;
  }
  for (std::int64_t v = 0; v < cage.vertices.rows(); ++v) {
    result.max_distance = std::max(result.max_distance, distance(cage.vertices.row(v), surface));
  }
  result.mean_distance /= area_sum;
  return result;
}

/// Samples never exceed the bound of the maximum; their mean has an error of its own. Returns the bounds.
DistanceBounds expect_tight(const TriangleMesh& surface, const TriangleMesh& cage, int n = 24) {
  const DistanceBounds bounds = distance_bounds(surface, cage);
  const DistanceBounds samples = sampled(surface, cage, n);
  EXPECT_GE(bounds.max_distance, samples.max_distance);
  EXPECT_LE(bounds.max_distance, 1.04 * samples.max_distance);
  EXPECT_GE(bounds.mean_distance, 0.999 * samples.mean_distance);
  EXPECT_LE(bounds.mean_distance, 1.02 * samples.mean_distance);
  return bounds;
}

/// A cube's surface with n^2 squares a side.
TriangleMesh fine_cube(double half, int n) {
  TriangleMesh result;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      std::vector<std::array<double, 3>> vertices;
      std::vector<std::array<std::int32_t, 3>> triangles;
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
          std::array<double, 3> p{};
          p[axis] = side * half;
          p[(axis + 1) % 3] = half * (2.0 * i / n - 1);
          p[(axis + 2) % 3] = half * (2.0 * j / n - 1);
          vertices.push_back(p);
          if (i == n || j == n) continue;
          const std::int32_t a = i * (n + 1) + j, b = a + n + 1;
          triangles.insert(triangles.end(), {{a, b, b + 1}, {a, b + 1, a + 1}});
        }
      }
      TriangleMesh face = shapes::mesh(vertices, triangles);
      if (side < 0) face = shapes::flipped(face);
      result = axis == 0 && side < 0 ? face : shapes::joined(result, face);
    }
  }
  return sanitize(result).obstacle;
}

TEST(CageDistance, CubeInACube) {
  // A face of the outer cube: a square at distance 1/2, four strips over edges, four corners.
  double mean = 4 * 0.5;
  constexpr int steps = 500;
  for (int i = 0; i < steps; ++i) {
    const double x = (i + 0.5) / steps / 2;
    mean += 4 * 2 * std::sqrt(0.25 + x * x) / steps / 2;
    for (int j = 0; j < steps; ++j) {
      const double y = (j + 0.5) / steps / 2;
      mean += 4 * std::sqrt(0.25 + x * x + y * y) / steps / steps / 4;
    }
  }
  mean /= 9;
  const TriangleMesh outer = cube(1.5);
  for (const TriangleMesh& inner : {cube(1), fine_cube(1, 2), fine_cube(1, 17)}) {
    const DistanceBounds bounds = distance_bounds(inner, outer);
    EXPECT_GE(bounds.max_distance, std::sqrt(0.75));
    EXPECT_LT(bounds.max_distance, std::sqrt(0.75) * 1.001);
    EXPECT_GE(bounds.mean_distance, mean * (1 - 1e-6));
    EXPECT_LT(bounds.mean_distance, mean * 1.03);
  }
}

TEST(CageDistance, AThinGapAroundManySmallTrianglesIsMeasured) {
  for (const double gap : {1e-2, 1e-4, 1e-6}) {
    const DistanceBounds bounds = distance_bounds(fine_cube(1, 20), cube(1 + gap));
    EXPECT_GE(bounds.max_distance, gap * std::sqrt(3.0));
    EXPECT_LT(bounds.max_distance, gap * std::sqrt(3.0) * 1.03);
    EXPECT_GE(bounds.mean_distance, gap * (1 - 1e-9));
    EXPECT_LT(bounds.mean_distance, gap * 1.03);
  }
}

TEST(CageDistance, AgreesWithSamples) {
  expect_tight(shapes::torus(2, 0.5, 12, 6), shapes::torus(2, 0.8, 7, 4), 24);
  expect_tight(shapes::sphere(2), cube(1.2));
  expect_tight(shapes::sphere(2), shapes::moved(shapes::tetrahedron(9), {-2, -2, -2}));
  // Far apart, and the surface outside of the "cage".
  expect_tight(cube(1, {30, 2, 1}), cube(1.5));
  expect_tight(cube(3), shapes::sphere(1));
}

TEST(CageDistance, SurfacesNeedNotBeSolids) {
  TriangleMesh cards = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  shapes::Random random(7);
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d at = random.point(1);
    cards = shapes::with_triangle(cards, at, at + random.point(0.3), at + random.point(0.3));
    // A card of two triangles that face opposite sides.
    if (i % 3 == 0) cards = shapes::joined(cards, shapes::flipped(cards));
    if (cards.triangles.rows() > 200) break;
  }
  expect_tight(cards, cube(1.4));
}

TEST(CageDistance, RandomSurfaces) {
  shapes::Random random(11);
  for (int trial = 0; trial < 12; ++trial) {
    TriangleMesh surface = shapes::mesh({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}});
    const double size = trial % 3 == 0 ? 0.05 : 1;
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d a = random.point(1), u = random.point(size), v = random.point(size);
      // Whole triangles, slivers, segments and points.
      const double thin = i % 4 == 0 ? 0 : i % 4 == 1 ? 1e-9 : 1;
      surface = shapes::with_triangle(surface, a, a + u, a + u / 2 + thin * v);
    }
    expect_tight(surface, shapes::box({-1.5, -1.2, -1.4}, {1.5, 1.3, 1.1}));
  }
}

TEST(CageDistance, ASurfaceThatFoldsBackIsNoCover) {
  // Two strips that overlap seen from above, joined at a hidden edge, with a gap between them that only samples see.
  const TriangleMesh fold = shapes::mesh({{-1, -1, 0},
                                          {0.2, -1, 0},
                                          {0.2, 1, 0},
                                          {-1, 1, 0},
                                          {-0.3, -1, -0.6},
                                          {-0.3, 1, -0.6},
                                          {1, -1, -0.7},
                                          {1, 1, -0.7}},
                                         {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}, {4, 6, 7}, {4, 7, 5}});
  expect_tight(fold, shapes::mesh({{-1, -1, 0.1}, {1, -1, 0.1}, {1, 1, 0.1}, {-1, 1, 0.1}}, {{0, 1, 2}, {0, 2, 3}}));
}

TEST(CageDistance, AHoleInASurfaceIsFound) {
  // A plane of small squares without one of them, and a cage that is near the plane everywhere.
  TriangleMesh plane = fine_cube(1, 12);
  std::vector<std::array<std::int32_t, 3>> kept;
  for (std::int64_t t = 0; t < plane.triangles.rows(); ++t) {
    const Eigen::Vector3d middle = (plane.corner(t, 0) + plane.corner(t, 1) + plane.corner(t, 2)) / 3;
    const bool hole = middle.z() > 0.99 && std::abs(middle.x()) < 1 / 6.0 && std::abs(middle.y()) < 1 / 6.0;
    if (!hole) kept.push_back({plane.triangles(t, 0), plane.triangles(t, 1), plane.triangles(t, 2)});
  }
  plane.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t t = 0; t < kept.size(); ++t) {
    for (int k = 0; k < 3; ++k) plane.triangles(static_cast<Eigen::Index>(t), k) = kept[t][k];
  }
  const DistanceBounds bounds = distance_bounds(plane, cube(1.001));
  EXPECT_GE(bounds.max_distance, 1 / 6.0);
  EXPECT_LT(bounds.max_distance, 1.02 / 6.0);
}

TEST(CageDistance, MeshesWithoutTrianglesAreRefused) {
  EXPECT_THROW(distance_bounds({}, cube(1)), Error);
  EXPECT_THROW(distance_bounds(cube(1), {}), Error);
}

}  // namespace
}  // namespace encage
