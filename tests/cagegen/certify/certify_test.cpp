// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/certify.h"

#include "oracles/meshes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace encage {
namespace {

using shapes::cube;
using shapes::flipped;
using shapes::joined;
using shapes::moved;
using shapes::scaled;
using shapes::sphere;
using shapes::with_triangle;

/// What the bound may lose (docs/certificate.md), for pairs of triangles within 3 units.
constexpr double rounding = 3 * 0x1p-45;

Certificate expect_holds(const TriangleMesh& inner, const TriangleMesh& cage, Solid solid = Solid::closed) {
  const CertifyResult result = certify(inner, solid, cage);
  EXPECT_TRUE(result.holds) << result.reason;
  EXPECT_EQ(result.reason, "");
  EXPECT_GT(result.certificate.clearance, 0);
  return result.certificate;
}

std::string refusal(const TriangleMesh& inner, const TriangleMesh& cage, Solid solid = Solid::closed) {
  const CertifyResult result = certify(inner, solid, cage);
  EXPECT_FALSE(result.holds);
  return result.reason;
}

TEST(Certify, NestedCubes) {
  const Certificate c = expect_holds(cube(1), cube(1.5));
  EXPECT_LE(c.clearance, 0.5);
  EXPECT_GE(c.clearance, 0.5 - rounding);
  EXPECT_DOUBLE_EQ(c.volume, 27);
  EXPECT_EQ(c.components, 1);
  EXPECT_EQ(c.cavities, 0);
  EXPECT_EQ(c.genus, 0);
  EXPECT_EQ(c.no_new_handles, true);
}

TEST(Certify, NestedSpheres) {
  const Certificate c = expect_holds(scaled(sphere(3), 0.5), sphere(3));
  // The nearest point of the outer polyhedron to the inner vertex below it is on a face.
  EXPECT_LT(c.clearance, 0.5);
  EXPECT_GT(c.clearance, 0.45);
}

TEST(Certify, Torus) {
  const TriangleMesh inner = shapes::torus(2, 0.3, 30, 9);
  const TriangleMesh cage = shapes::torus(2, 0.6, 24, 8);
  const Certificate c = expect_holds(inner, cage);
  EXPECT_EQ(c.genus, 1);
  EXPECT_EQ(c.no_new_handles, true);
  EXPECT_EQ(expect_holds(inner, cube(4)).no_new_handles, true) << "a handle may be lost";
  EXPECT_EQ(expect_holds(moved(cube(0.1), {2, 0, 0}), cage).no_new_handles, false);
}

TEST(Certify, HandlesAreNotComparedWithOpenSurfaces) {
  TriangleMesh open = cube(1);
  open.triangles.conservativeResize(11, 3);
  EXPECT_EQ(expect_holds(open, cube(2), Solid::surface_only).no_new_handles, std::nullopt);
  EXPECT_EQ(refusal(open, cube(2)), "inner mesh is said to be closed but is open at edge 1-5");
}

TEST(Certify, Contact) {
  const TriangleMesh cage = cube(2);
  const auto touches = [&](const TriangleMesh& inner) {
    const std::string reason = refusal(inner, cage, Solid::surface_only);
    EXPECT_TRUE(reason.starts_with("cage triangle ") && reason.find(" touches inner triangle ") != std::string::npos)
        << reason;
  };
  touches(moved(shapes::tetrahedron(1), {1, 0, 0}));                            // vertex on a face
  touches(with_triangle(cube(1), {0, 0, 0}, {2, 2, 2}, {0, 1, 0}));             // vertex on a vertex
  touches(with_triangle(cube(1), {2, 0.5, 0.25}, {2, -0.5, 0.25}, {0, 0, 0}));  // edge in a face
  touches(with_triangle(cube(1), {2, 2, -1}, {2, 2, 1}, {0, 0, 0}));            // edge on an edge
  touches(moved(cube(1), {1, 0, 0}));                                           // coplanar faces
  touches(moved(cube(1), {1.5, 0, 0}));                                         // through a face
  touches(cage);                                                                // all of it
}

TEST(Certify, DegenerateInnerTriangles) {
  const TriangleMesh cage = cube(2);
  const Eigen::Vector3d origin(0, 0, 0), before(1.9, 0.1, 0), on(2, 0.1, 0), beyond(2.1, 0.1, 0);
  const auto with = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return with_triangle(cube(1), a, b, c);
  };
  expect_holds(with(before, before, before), cage, Solid::surface_only);
  expect_holds(with(origin, before, 0.5 * before), cage, Solid::surface_only);
  EXPECT_NEAR(expect_holds(with(before, origin, before), cage, Solid::surface_only).clearance, 0.1, 1e-9);
  for (const Eigen::Vector3d& end : {on, beyond}) {
    EXPECT_NE(refusal(with(origin, end, before), cage, Solid::surface_only).find("inner triangle 12"),
              std::string::npos);
    EXPECT_NE(refusal(with(end, end, origin), cage, Solid::surface_only).find("inner triangle 12"), std::string::npos);
  }
  EXPECT_NE(refusal(with(on, on, on), cage, Solid::surface_only).find("touches inner triangle 12"), std::string::npos);
  EXPECT_EQ(refusal(with(beyond, beyond, beyond), cage, Solid::surface_only),
            "the component of inner triangle 12 lies outside the cage");
}

TEST(Certify, DegenerateInnerTrianglesOfASolid) {
  // A collinear spike on an edge: closed, hence a solid, with a triangle of no area.
  TriangleMesh inner = shapes::tetrahedron(1);
  inner.vertices.conservativeResize(5, 3);
  inner.vertices.row(4) << 0.5, 0, 0;
  inner.triangles.conservativeResize(6, 3);
  inner.triangles.row(0) << 0, 2, 4;
  inner.triangles.row(4) << 4, 2, 1;
  inner.triangles.row(5) << 0, 4, 1;  // fills the T-junction
  const Certificate c = expect_holds(inner, cube(2));
  EXPECT_EQ(c.no_new_handles, true);
  inner.vertices.row(4) << 3, 0, 0;
  EXPECT_NE(refusal(inner, cube(2)).find("touches inner triangle"), std::string::npos);
}

TEST(Certify, EveryComponentOfTheInnerMeshMustBeInside) {
  const TriangleMesh two = joined(cube(1), cube(1, {10, 0, 0}));
  EXPECT_EQ(refusal(two, cube(2)), "the component of inner triangle 12 lies outside the cage");
  expect_holds(two, joined(cube(2), cube(2, {10, 0, 0})));
  EXPECT_EQ(refusal(cube(4), cube(2)), "the component of inner triangle 0 lies outside the cage");
}

TEST(Certify, Cavities) {
  const TriangleMesh shell = joined(cube(4), flipped(cube(1)));
  const TriangleMesh beside = cube(0.5, {2.5, 0, 0});
  const Certificate c = expect_holds(beside, shell);
  EXPECT_EQ(c.components, 2);
  EXPECT_EQ(c.cavities, 1);
  EXPECT_DOUBLE_EQ(c.volume, 512 - 8);
  EXPECT_EQ(refusal(cube(0.5), shell), "the component of inner triangle 0 lies outside the cage");
  // The inner solid reaches around the cavity.
  EXPECT_EQ(refusal(cube(2), shell), "the component of cage triangle 12 lies inside the inner solid");
  // Its surface alone does not.
  expect_holds(cube(2), shell, Solid::surface_only);
  // A cavity of the inner solid may hold one of the cage.
  expect_holds(joined(cube(3), flipped(cube(2))), shell);
}

TEST(Certify, Orientation) {
  EXPECT_EQ(refusal(cube(1), flipped(cube(2))),
            "the component of cage triangle 0 is turned inward but is no cavity of another");
  EXPECT_EQ(refusal(cube(1), joined(cube(2), cube(3))),
            "the component of cage triangle 0 lies inside another component");
  EXPECT_EQ(refusal(cube(1), joined(cube(2), flipped(cube(1, {9, 0, 0})))),
            "the component of cage triangle 12 is turned inward but is no cavity of another");
  // An island in a cavity is sound; a cavity in a cavity is not.
  const TriangleMesh shell = joined(cube(5), flipped(cube(3)));
  expect_holds(cube(1), joined(shell, cube(2)));
  EXPECT_EQ(refusal(cube(1), joined(shell, flipped(cube(2)))),
            "the component of cage triangle 24 is turned inward but is no cavity of another");
}

TEST(Certify, CagesThatAreNoSoundSurface) {
  TriangleMesh open = cube(2);
  open.triangles.conservativeResize(11, 3);
  EXPECT_EQ(refusal(cube(1), open), "cage edge 1-5 of triangle 4 has no other triangle");

  TriangleMesh turned = cube(2);
  turned.triangles.row(3).reverseInPlace();
  EXPECT_NE(refusal(cube(1), turned).find("in the same direction"), std::string::npos);

  TriangleMesh sharp = joined(shapes::tetrahedron(1), shapes::tetrahedron(-1));
  for (Eigen::Index i = 0; i < sharp.triangles.size(); ++i) {
    if (sharp.triangles.data()[i] == 4) sharp.triangles.data()[i] = 0;
  }
  EXPECT_EQ(refusal(cube(0.1), sharp), "cage vertex 0 joins several fans of triangles");

  // The midpoint of an edge as an extra vertex on both sides, one triangle of no area.
  TriangleMesh flat = shapes::tetrahedron(4, {-1, -1, -1});
  flat.vertices.conservativeResize(5, 3);
  flat.vertices.row(4) << 1, -1, -1;
  flat.triangles.conservativeResize(6, 3);
  flat.triangles.row(0) << 0, 2, 4;
  flat.triangles.row(4) << 4, 2, 1;
  flat.triangles.row(5) << 0, 4, 1;
  EXPECT_EQ(refusal(cube(0.1), flat), "cage triangle 5 is degenerate");

  const std::string crossed = refusal(cube(1), joined(cube(2), cube(2, {3, 0, 0})));
  EXPECT_TRUE(crossed.starts_with("cage triangles ") && crossed.ends_with(" intersect")) << crossed;
}

TEST(Certify, SelfIntersectionAlsoBetweenNeighbours) {
  TriangleMesh cage = scaled(sphere(2), 3);
  expect_holds(cube(0.5), cage);
  cage.vertices.row(0) *= -1.5;
  EXPECT_NE(refusal(cube(0.1, {0, 2, 0}), cage).find(" intersect"), std::string::npos);
}

TEST(Certify, MalformedMeshes) {
  EXPECT_EQ(refusal(cube(1), TriangleMesh{}), "cage has no triangles");
  EXPECT_EQ(refusal(TriangleMesh{}, cube(1)), "inner mesh has no triangles");
  TriangleMesh bad = cube(2);
  bad.triangles(3, 1) = 8;
  EXPECT_EQ(refusal(cube(1), bad), "cage triangle 3 refers to vertex 8, which does not exist");
  bad.triangles(3, 1) = -1;
  EXPECT_EQ(refusal(bad, cube(3)), "inner mesh triangle 3 refers to vertex -1, which does not exist");
  for (const double x : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e76}) {
    bad = cube(2);
    bad.vertices(5, 1) = x;
    EXPECT_EQ(refusal(cube(1), bad), "cage vertex 5 is not finite or beyond 1e75");
  }
}

TEST(Certify, TinyClearances) {
  for (const double gap : {1e-6, 1e-9, 1e-12, 1e-15}) {
    const double half = 1 + gap;  // rounded: the gap in the meshes is half - 1
    const Certificate c = expect_holds(cube(1), cube(half));
    EXPECT_LE(c.clearance, half - 1);
    EXPECT_GE(c.clearance, (half - 1) * (1 - 2e-6) - 0x1p-45 * 2 * half);
    EXPECT_NE(refusal(cube(half), cube(1)), "");
  }
}

TEST(Certify, LargeOffsets) {
  for (const double far : {1e3, 1e7, 1e12}) {
    const Eigen::Vector3d at(far, -far, 3 * far);
    const Certificate c = expect_holds(cube(1, at), cube(1.5, at));
    EXPECT_LE(c.clearance, 0.5);
    EXPECT_GE(c.clearance, 0.5 - rounding);
    EXPECT_NEAR(c.volume, 27, 1e-9);
    EXPECT_NE(refusal(cube(1, at), cube(1, at)), "");
  }
}

TEST(Certify, AllSizesOfFloat32) {
  for (const double size : {1e-38, 1e-30, 1e-12, 1e12, 1e30, 1e38}) {
    const Certificate c = expect_holds(cube(size), cube(1.5 * size));
    EXPECT_LE(c.clearance, 0.5 * size * (1 + 1e-15));
    EXPECT_GE(c.clearance, 0.5 * size * (1 - 1e-6));
  }
}

TEST(Certify, ManyCoplanarTriangles) {
  // Every vertex of the grid has a flat fan, every line of sight meets edges and vertices.
  const int n = 12;
  std::vector<std::array<double, 3>> v;
  std::vector<std::array<std::int32_t, 3>> f;
  for (int side = 0; side < 2; ++side) {
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) v.push_back({double(i), double(j), double(side)});
    }
  }
  const auto id = [&](int side, int i, int j) { return (side * (n + 1) + i) * (n + 1) + j; };
  const auto quad = [&](std::int32_t a, std::int32_t b, std::int32_t c, std::int32_t d) {
    f.push_back({a, b, c});
    f.push_back({a, c, d});
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      quad(id(1, i, j), id(1, i + 1, j), id(1, i + 1, j + 1), id(1, i, j + 1));
      quad(id(0, i, j), id(0, i, j + 1), id(0, i + 1, j + 1), id(0, i + 1, j));
    }
    quad(id(0, i, 0), id(0, i + 1, 0), id(1, i + 1, 0), id(1, i, 0));
    quad(id(0, i + 1, n), id(0, i, n), id(1, i, n), id(1, i + 1, n));
    quad(id(0, 0, i + 1), id(0, 0, i), id(1, 0, i), id(1, 0, i + 1));
    quad(id(0, n, i), id(0, n, i + 1), id(1, n, i + 1), id(1, n, i));
  }
  const TriangleMesh slab = shapes::mesh(v, f);
  const TriangleMesh inner = shapes::box({1, 1, 0.25}, {n - 1.0, n - 1.0, 0.75});
  const Certificate c = expect_holds(inner, slab);
  EXPECT_GE(c.clearance, 0.25 - n * rounding);
  EXPECT_DOUBLE_EQ(c.volume, n * n);
}

TEST(Certify, Repeatable) {
  const TriangleMesh inner = shapes::torus(2, 0.3, 30, 9);
  const TriangleMesh cage = shapes::torus(2, 0.6, 24, 8);
  const Certificate first = expect_holds(inner, cage);
  EXPECT_EQ(expect_holds(inner, cage).clearance, first.clearance);
}

TEST(CertifyAlone, ProvesTheCageOnly) {
  const CertifyResult sound = certify_alone(shapes::torus(2, 0.6, 24, 8));
  EXPECT_TRUE(sound.holds) << sound.reason;
  EXPECT_EQ(sound.certificate.genus, 1);
  EXPECT_EQ(certify_alone(flipped(cube(1))).reason,
            "the component of cage triangle 0 is turned inward but is no cavity of another");
}

}  // namespace
}  // namespace encage
