// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/exact.h"
#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>

namespace encage {
namespace {

using test::box;
using test::inside_out;
using test::joined;
using test::mesh_of;
using test::sheet;
using test::with_triangles;
using test::with_vertex;
using test::without_triangles;
using Place = std::array<double, 3>;

constexpr double pi = 3.14159265358979323846;

Place place(const Eigen::Vector3d& p) { return {p[0], p[1], p[2]}; }

bool is_degenerate(const TriangleMesh& mesh, std::int64_t t) {
  return proof::degenerate({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
}

/// By maps of edges and vertices: every edge once in each direction, every link one cycle.
bool is_manifold(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> directed;
  std::map<int, std::map<int, int>> links;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3), c = mesh.triangles(t, (k + 2) % 3);
      if (!directed.emplace(a, b).second || !links[a].emplace(b, c).second) return false;
    }
  }
  for (const auto& [a, b] : directed) {
    if (!directed.contains({b, a})) return false;
  }
  for (const auto& [v, link] : links) {
    std::size_t length = 0;
    int at = link.begin()->first;
    do {
      at = link.at(at);
      ++length;
    } while (at != link.begin()->first);
    if (length != link.size()) return false;
  }
  return true;
}

/// What holds for every result; `input` is what it came from.
void expect_consistent(const SourceMesh& source, const TriangleMesh& input) {
  if (source.solid != Solid::surface_only) {
    EXPECT_TRUE(is_closed(source.obstacle));
  } else if (is_closed(source.obstacle)) {
    EXPECT_NEAR(signed_volume(source.obstacle) / std::pow(source.diagonal, 3), 0, 1e-9) << "a solid was missed";
  }
  EXPECT_TRUE(source.solid == Solid::surface_only || is_closed(source.clean));
  EXPECT_EQ(source.solid == Solid::capped, source.cap_count > 0);
  EXPECT_EQ(source.manifold, is_manifold(source.clean));
  EXPECT_GT(source.diagonal, 0);
  if (source.solid == Solid::surface_only) {
    EXPECT_EQ(source.volume, 0);
  } else {
    EXPECT_GT(source.volume, 0);
  }
  std::set<Place> places;
  std::set<std::set<Place>> triangles;
  for (std::int64_t t = 0; t < source.clean.triangles.rows(); ++t) {
    EXPECT_FALSE(is_degenerate(source.clean, t)) << t;
    for (int k = 0; k < 3; ++k) places.insert(place(source.origin + source.clean.corner(t, k)));
  }
  for (std::int64_t t = 0; t < source.obstacle.triangles.rows(); ++t) {
    std::set<Place> corners;
    for (int k = 0; k < 3; ++k) corners.insert(place(source.origin + source.obstacle.corner(t, k)));
    triangles.insert(corners);
  }
  const auto used = [](const TriangleMesh& mesh) {
    std::set<int> vertices;
    for (const int v : mesh.triangles.reshaped()) vertices.insert(v);
    return static_cast<Eigen::Index>(vertices.size());
  };
  EXPECT_EQ(used(source.obstacle), source.obstacle.vertices.rows());
  EXPECT_EQ(used(source.clean), source.clean.vertices.rows());
  // Nothing that was read is lost or moved.
  for (std::int64_t t = 0; t < input.triangles.rows(); ++t) {
    std::set<Place> corners;
    for (int k = 0; k < 3; ++k) corners.insert(place(input.corner(t, k)));
    if (!is_degenerate(input, t)) {
      EXPECT_TRUE(triangles.contains(corners)) << t;
    } else {
      // A segment ends in its lexicographically first and last point.
      EXPECT_TRUE(places.contains(*corners.begin())) << t;
      EXPECT_TRUE(places.contains(*corners.rbegin())) << t;
      EXPECT_TRUE(triangles.contains(corners) || triangles.contains({*corners.begin(), *corners.rbegin()})) << t;
    }
  }
}

SourceMesh sanitized(const TriangleMesh& input) {
  SourceMesh source = sanitize(input);
  expect_consistent(source, input);
  return source;
}

std::string refusal(const TriangleMesh& input) {
  try {
    sanitize(input);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(Sanitize, LeavesACleanMeshAsItIs) {
  const TriangleMesh input = box({-1, -2, -3}, {1, 2, 3});
  const SourceMesh source = sanitized(input);
  EXPECT_EQ(source.solid, Solid::closed);
  EXPECT_TRUE(source.manifold);
  EXPECT_EQ(source.obstacle.vertices, input.vertices);
  EXPECT_EQ(source.obstacle.triangles, input.triangles);
  EXPECT_EQ(source.clean.vertices, input.vertices);
  EXPECT_EQ(source.clean.triangles, input.triangles);
  EXPECT_EQ(source.volume, 48);
  EXPECT_EQ(source.diagonal, std::sqrt(4. + 16 + 36));
  EXPECT_EQ(source.origin, Eigen::Vector3d::Zero());
  EXPECT_EQ(source.report.flipped_components + source.report.welded_vertices + source.report.isolated_vertices +
                source.report.duplicate_triangles + source.report.degenerate_triangles + source.report.capped_loops,
            0);
}

TEST(Sanitize, HashTellsInputsApart) {
  const TriangleMesh input = box();
  TriangleMesh moved = input;
  moved.vertices(0, 0) = -1e-300;
  EXPECT_EQ(sanitize(input).hash, sanitize(input).hash);
  EXPECT_NE(sanitize(input).hash, sanitize(moved).hash);
  EXPECT_NE(sanitize(input).hash, sanitize(inside_out(input)).hash);
}

TEST(Sanitize, WeldsEqualVerticesAndDropsUnusedOnes) {
  TriangleMesh soup;  // every triangle with its own vertices
  const TriangleMesh cube = box();
  for (std::int64_t t = 0; t < 12; ++t) {
    soup = joined({soup, mesh_of({cube.corner(t, 0), cube.corner(t, 1), cube.corner(t, 2)}, {{0, 1, 2}})});
  }
  for (double& x : soup.vertices.topRows(3).reshaped()) x = x == 0 ? -0.0 : x;
  soup = with_vertex(with_vertex(soup, {9, 9, 9}), {0, 0, 0});
  const SourceMesh source = sanitized(soup);
  EXPECT_TRUE(source.manifold);
  EXPECT_EQ(source.report.welded_vertices, 28);
  EXPECT_EQ(source.report.isolated_vertices, 2);
  EXPECT_EQ(source.volume, 1);
  EXPECT_EQ(source.diagonal, std::sqrt(3.));
}

TEST(Sanitize, TurnsInsideOutMeshes) {
  const SourceMesh source = sanitized(inside_out(box()));
  EXPECT_EQ(source.volume, 1);
  EXPECT_TRUE(source.manifold);
  EXPECT_EQ(source.report.flipped_components, 1);
}

TEST(Sanitize, MakesOrientationConsistent) {
  TriangleMesh input = box();
  for (const int t : {0, 4, 5, 11}) std::swap(input.triangles(t, 0), input.triangles(t, 1));
  const SourceMesh source = sanitized(input);
  EXPECT_EQ(source.volume, 1);
  EXPECT_TRUE(source.manifold);
}

TEST(Sanitize, DropsDuplicates) {
  const SourceMesh same = sanitized(with_triangles(box(), {{2, 3, 0}, {0, 2, 3}}));
  EXPECT_EQ(same.report.duplicate_triangles, 2);
  EXPECT_TRUE(same.manifold);
  const SourceMesh opposite = sanitized(with_triangles(box(), {{0, 3, 2}}));
  EXPECT_EQ(opposite.report.duplicate_triangles, 1);
  EXPECT_TRUE(opposite.manifold);
  EXPECT_EQ(opposite.obstacle.triangles, box().triangles);
}

TEST(Sanitize, KeepsBothSidesOfAMembraneThatClosesTheSurface) {
  const TriangleMesh membrane = mesh_of({{.2, .2, .5}, {.8, .2, .5}, {.5, .8, .5}}, {{0, 1, 2}, {0, 2, 1}});
  const SourceMesh source = sanitized(joined({box(), membrane}));
  EXPECT_EQ(source.solid, Solid::closed);
  EXPECT_EQ(source.cap_count, 0);
  EXPECT_EQ(source.report.duplicate_triangles, 0);
  EXPECT_EQ(source.obstacle.triangles.rows(), 14);
}

TEST(Sanitize, CapsAnOpenBox) {
  const SourceMesh source = sanitized(without_triangles(box(), 2, 2));
  EXPECT_EQ(source.solid, Solid::capped);
  EXPECT_EQ(source.cap_count, 2);
  EXPECT_EQ(source.report.capped_loops, 1);
  EXPECT_TRUE(source.manifold);
  EXPECT_NEAR(source.volume, 1, 1e-15);
}

TEST(Sanitize, CapsAnInsideOutOpenBox) {
  EXPECT_NEAR(sanitized(inside_out(without_triangles(box(), 2, 2))).volume, 1, 1e-15);
}

TEST(Sanitize, CapsHolesThatShareAVertex) {
  const TriangleMesh octahedron =
      mesh_of({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
              {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
  const SourceMesh source = sanitized(without_triangles(without_triangles(octahedron, 2, 1), 0, 1));
  EXPECT_EQ(source.solid, Solid::capped);
  EXPECT_EQ(source.report.capped_loops, 2);
  EXPECT_TRUE(source.manifold);
  EXPECT_NEAR(source.volume, 4. / 3, 1e-15);
}

/// The triangulation of least area of such a border is the surface itself.
TEST(Sanitize, CapsDoNotFoldBackOntoTheSurface) {
  const TriangleMesh half_pipe = sheet(24, [](double, double) { return 0; });
  TriangleMesh input = half_pipe;
  for (Eigen::Index v = 0; v < input.vertices.rows(); ++v) {
    const double angle = pi * half_pipe.vertices(v, 0);
    input.vertices.row(v) << -std::cos(angle), 3 * half_pipe.vertices(v, 1), std::sin(angle);
  }
  const SourceMesh source = sanitized(input);
  EXPECT_EQ(source.solid, Solid::capped);
  EXPECT_TRUE(source.manifold);
  EXPECT_GT(source.volume, 0.97 * 3 * pi / 2);
}

TEST(Sanitize, CapsALongBorder) {
  const auto bowl = [](double x, double y) { return (x - .5) * (x - .5) + (y - .5) * (y - .5); };
  const SourceMesh source = sanitized(sheet(100, bowl));
  EXPECT_EQ(source.solid, Solid::capped);
  EXPECT_EQ(source.report.capped_loops, 1);
  EXPECT_EQ(source.cap_count, 398);
  EXPECT_GT(source.volume, 0.1);
}

TEST(Sanitize, CapsDoNotDependOnMemory) {
  // Along a flat, regular border many triangulations are equally good.
  const TriangleMesh flat = sheet(8, [](double x, double y) { return x / 2 + y / 3; });
  const TriangleMesh wavy = sheet(8, [](double x, double y) { return 0.8 - x / 2 - y / 3 - std::sin(7 * x) / 20; });
  const TriangleMesh input = joined({flat, wavy});
  const SourceMesh first = sanitize(input);
  ASSERT_EQ(first.solid, Solid::capped);
  std::vector<std::unique_ptr<char[]>> holes;
  for (int i = 0; i < 40; ++i) {
    for (int k = 0; k < 200 * i; ++k) {
      auto block = std::make_unique<char[]>(20 + static_cast<std::size_t>(k) * 7 % 600);
      if (k % 3 == 0) holes.push_back(std::move(block));
    }
    const SourceMesh again = sanitize(input);
    ASSERT_EQ(again.clean.triangles, first.clean.triangles) << i;
    ASSERT_EQ(again.obstacle.triangles, first.obstacle.triangles) << i;
  }
}

TEST(Sanitize, ClosesASlit) {
  // One side of the edge from 0 to 1 is split in the middle, the other is not.
  TriangleMesh input = with_vertex(box(), {.5, 0, 0});
  input = with_triangles(without_triangles(input, 4, 1), {{0, 8, 5}, {8, 1, 5}});
  const SourceMesh source = sanitized(input);
  EXPECT_EQ(source.solid, Solid::capped);
  EXPECT_EQ(source.cap_count, 1);
  EXPECT_TRUE(source.manifold);
  EXPECT_EQ(source.clean.vertices.rows(), 9) << "flipped, not split";
  EXPECT_EQ(source.volume, 1);
}

TEST(Sanitize, FlatSheetsHaveNoInterior) {
  const auto plane = [](double x, double y) { return x / 3 + y / 7; };
  for (const TriangleMesh& input :
       {mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}), sheet(1, plane), sheet(30, plane), sheet(90, plane)}) {
    const SourceMesh source = sanitized(input);
    EXPECT_EQ(source.solid, Solid::surface_only);
    EXPECT_EQ(source.cap_count, 0);
    EXPECT_EQ(source.report.capped_loops, 0);
    EXPECT_EQ(source.obstacle.triangles.rows(), input.triangles.rows());
    EXPECT_FALSE(source.manifold);
  }
}

TEST(Sanitize, TwoSidedFlatSheetHasNoInterior) {
  const TriangleMesh triangle = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {2, 1, 0}});
  EXPECT_EQ(sanitize(triangle).solid, Solid::surface_only);
}

TEST(Sanitize, SurfacesThatCannotBeClosedGetNoCaps) {
  // Three pages on one spine; a Moebius strip of five triangles.
  const TriangleMesh book =
      mesh_of({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
  const TriangleMesh strip = mesh_of({{0, 0, 0}, {1, 0, .3}, {1.5, 1, 0}, {.5, 1.7, .4}, {-.5, 1, 1}},
                                     {{0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {3, 4, 0}, {4, 0, 1}});
  for (const TriangleMesh& input : {book, strip, joined({box(), book})}) {
    const SourceMesh source = sanitized(input);
    EXPECT_EQ(source.solid, Solid::surface_only);
    EXPECT_EQ(source.cap_count, 0);
  }
}

TEST(Sanitize, AcceptsNonManifoldVerticesAndEdges) {
  for (const Eigen::Vector3d& low : {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(1, 1, 0)}) {
    const SourceMesh source = sanitized(joined({box(), inside_out(box(low, low + Eigen::Vector3d::Ones()))}));
    EXPECT_EQ(source.solid, Solid::closed);
    EXPECT_FALSE(source.manifold);
    EXPECT_NEAR(source.volume, 2, 1e-12);
    EXPECT_EQ(source.report.flipped_components, 1);
  }
}

TEST(Sanitize, KeepsCavitiesAndIslands) {
  const TriangleMesh outer = box({0, 0, 0}, {9, 9, 9}), middle = box({3, 3, 3}, {6, 6, 6}),
                     inner = box({4, 4, 4}, {5, 5, 5});
  const struct {
    TriangleMesh mesh;
    double volume;
    std::int64_t flipped;
  } cases[] = {
      {joined({outer, inside_out(middle)}), 729 - 27, 0},                     // a cavity
      {joined({inside_out(outer), middle}), 729 - 27, 2},                     // the same, inside out
      {joined({inside_out(middle), outer}), 729 - 27, 0},                     // the inner one comes first
      {joined({outer, middle}), 729, 0},                                      // overlapping solids
      {joined({inside_out(outer), inside_out(middle)}), 729, 2},              // the same, inside out
      {joined({outer, inside_out(middle), inner}), 729 - 27 + 1, 0},          // an island in the cavity
      {joined({inside_out(outer), middle, inside_out(inner)}), 729 - 26, 3},  // the same, inside out
      {joined({outer, inside_out(middle), inside_out(inner)}), 729 - 26, 1},  // less than nothing: turned
      {joined({outer, inside_out(box({20, 0, 0}, {21, 1, 1}))}), 730, 1},     // beside, not inside
      {joined({outer, inside_out(box({8, 8, 8}, {10, 10, 10}))}), 736, 1},    // partly inside only
  };
  for (const auto& c : cases) {
    const SourceMesh source = sanitized(c.mesh);
    const bool exact = c.volume != 736;  // what intersects is measured by rays
    EXPECT_NEAR(source.volume, c.volume, exact ? 1e-9 : 0.7);
    EXPECT_EQ(source.report.flipped_components, c.flipped) << c.volume;
  }
}

TEST(Sanitize, FindsManyCavities) {
  TriangleMesh cheese = box({0, 0, 0}, {11, 11, 11});
  for (int i = 0; i < 125; ++i) {
    const Eigen::Vector3d low(1 + 2 * (i % 5), 1 + 2 * (i / 5 % 5), 1 + 2 * (i / 25));
    cheese = joined({cheese, inside_out(box(low, low + Eigen::Vector3d::Ones()))});
  }
  for (const TriangleMesh& input : {cheese, inside_out(cheese)}) {
    const SourceMesh source = sanitized(input);
    EXPECT_NEAR(source.volume, 1331 - 125, 1e-8);
    EXPECT_TRUE(source.manifold);
  }
}

TEST(Sanitize, KeepsSmallComponents) {
  const SourceMesh source = sanitized(joined({box(), box({5, 5, 5}, {5.00001, 5.00001, 5.00001})}));
  EXPECT_EQ(source.clean.triangles.rows(), 24);
  EXPECT_GT(source.diagonal, 8);
}

TEST(Sanitize, KeepsASpike) {
  // Vertex 8 lies on the line through 0 and 1, far outside; the second spike leaves a corner.
  TriangleMesh input = with_vertex(with_vertex(box(), {5, 0, 0}), {0, 0, -7});
  input = with_triangles(input, {{0, 1, 8}, {0, 9, 0}});
  const SourceMesh source = sanitized(input);
  EXPECT_EQ(source.solid, Solid::closed);
  EXPECT_EQ(source.volume, 1);
  EXPECT_EQ(source.report.degenerate_triangles, 2);
  EXPECT_FALSE(source.manifold);
  EXPECT_EQ(bounds(source.clean).max().x(), 5);
  EXPECT_EQ(bounds(source.clean).min().z(), -7);
  EXPECT_EQ(bounds(source.obstacle).max().x(), 5);
}

TEST(Sanitize, KeepsASpikeOfSeveralTriangles) {
  TriangleMesh input = with_vertex(with_vertex(box(), {2, 0, 0}), {3, 0, 0});
  input = with_triangles(input, {{0, 1, 8}, {1, 8, 9}, {8, 9, 1}});
  const SourceMesh source = sanitized(input);
  EXPECT_EQ(source.solid, Solid::closed);
  EXPECT_EQ(bounds(source.clean).max().x(), 3);
}

TEST(Sanitize, KeepsTheSurfaceClosedWhereNoFlipHelps) {
  // Both sides of the edge from 0 to 1 are split, at different points; two collinear triangles fill the seam and have
  // each other across their longest side.
  TriangleMesh input = with_vertex(with_vertex(box(), {.5, 0, 0}), {.25, 0, 0});
  input = without_triangles(without_triangles(input, 4, 1), 1, 1);
  input = with_triangles(input, {{0, 8, 5}, {8, 1, 5}, {0, 3, 9}, {9, 3, 1}, {0, 1, 8}, {1, 0, 9}});
  const SourceMesh source = sanitized(input);
  EXPECT_EQ(source.solid, Solid::closed);
  EXPECT_TRUE(source.manifold);
  EXPECT_EQ(source.report.degenerate_triangles, 2);
  EXPECT_EQ(source.clean.vertices.rows(), 12);
  EXPECT_NEAR(signed_volume(source.clean), 1, 1e-5);
}

TEST(Sanitize, TurnsNeedlesIntoThinTriangles) {
  const SourceMesh needle = sanitized(mesh_of({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}, {{0, 1, 2}, {1, 1, 2}, {2, 2, 2}}));
  EXPECT_EQ(needle.solid, Solid::surface_only);
  EXPECT_EQ(needle.report.degenerate_triangles, 3);
  EXPECT_EQ(bounds(needle.clean).max().x(), 3);
  EXPECT_EQ(bounds(needle.clean).min().x(), 0);
  const SourceMesh points = sanitized(mesh_of({{0, 0, 0}, {1, 2, 3}}, {{0, 0, 0}, {1, 1, 1}}));
  EXPECT_EQ(points.solid, Solid::surface_only);
  EXPECT_EQ(points.clean.triangles.rows(), 4);
}

TEST(Sanitize, RefusesWhatCannotBeBaked) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal({}), "the mesh has no triangles");
  EXPECT_EQ(refusal(with_vertex(box(), {0, nan, 0})), "vertex 8: coordinate is not finite");
  TriangleMesh mesh = box();
  mesh.vertices(5, 2) = -infinity;
  EXPECT_EQ(refusal(mesh), "vertex 5: coordinate is not finite");
  EXPECT_EQ(refusal(with_triangles(box(), {{0, 1, 8}})), "face 12: vertex index is out of range (8 vertices)");
  EXPECT_EQ(refusal(with_triangles(box(), {{0, 1, -1}})), "face 12: vertex index is out of range (8 vertices)");
  EXPECT_EQ(refusal(mesh_of({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {{0, 1, 2}})), "the mesh is a single point");
  for (const double huge : {1e38, 1e200, 1e308}) {
    EXPECT_EQ(refusal(box(Eigen::Vector3d::Constant(-huge), Eigen::Vector3d::Constant(huge))),
              "the mesh is too large for float32: its extent is above 1e37");
  }
  for (const double tiny : {1e-31, 1e-300}) {
    EXPECT_EQ(refusal(box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(tiny))),
              "the mesh is too small for float32: its extent is below 1e-30");
  }
}

TEST(Sanitize, AcceptsEveryScaleThatFloatHolds) {
  for (const double scale : {1e-29, 1e-10, 1e10, 9e36}) {
    const SourceMesh source = sanitized(box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(scale)));
    EXPECT_TRUE(source.manifold);
    EXPECT_NEAR(source.volume / (scale * scale * scale), 1, 1e-12);
  }
}

TEST(Sanitize, MovesToALocalFrameExactly) {
  // Diameter 1.2 at a distance of 1,000.
  TriangleMesh input = sheet(16, [](double x, double y) { return x * x - y / 3; });
  input.vertices.rowwise() += Eigen::RowVector3d(1000, -900, .1);
  const SourceMesh source = sanitized(input);
  EXPECT_NE(source.origin.x(), 0);
  EXPECT_EQ(source.origin.z(), 0);
  ASSERT_EQ(source.obstacle.vertices.rows(), input.vertices.rows());
  for (Eigen::Index v = 0; v < input.vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) {
      const long double sum = static_cast<long double>(source.origin[k]) + source.obstacle.vertices(v, k);
      EXPECT_EQ(sum, input.vertices(v, k));
    }
  }
  EXPECT_LT(source.obstacle.vertices.leftCols(2).cwiseAbs().maxCoeff(), 1);
}

/// Soups on a small grid have every defect at once; expect_consistent() checks them.
TEST(Sanitize, HoldsItsPromisesForRandomSoups) {
  std::mt19937 random(11);
  int solids = 0, degenerate = 0;
  for (int round = 0; round < 3000; ++round) {
    const int size = 2 + round % 3;
    std::uniform_int_distribution<int> coordinate(0, size - 1);
    std::vector<Eigen::Vector3d> vertices(4 + round % 7);
    for (Eigen::Vector3d& v : vertices) v = Eigen::Vector3d(coordinate(random), coordinate(random), coordinate(random));
    std::uniform_int_distribution<int> vertex(0, static_cast<int>(vertices.size()) - 1);
    std::vector<Eigen::Vector3i> triangles(1 + round % 17);
    for (Eigen::Vector3i& t : triangles) t = Eigen::Vector3i(vertex(random), vertex(random), vertex(random));
    const TriangleMesh input = mesh_of(vertices, triangles);
    if (refusal(input) == "the mesh is a single point") continue;
    const SourceMesh source = sanitized(input);
    ASSERT_FALSE(testing::Test::HasFailure()) << "round " << round;
    solids += source.solid != Solid::surface_only;
    degenerate += source.report.degenerate_triangles > 0;
  }
  EXPECT_GT(solids, 100);
  EXPECT_GT(degenerate, 1000);
}

/// A closed mesh with random damage that changes no point of it is still the same solid.
TEST(Sanitize, RepairsDamageOfAClosedMesh) {
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    TriangleMesh input = joined({box({0, 0, 0}, {4, 4, 4}), inside_out(box({1, 1, 1}, {2, 2, 2}))});
    if (round % 2) input = inside_out(input);
    for (int i = 0; i < round % 5; ++i) {
      const Eigen::Vector3i again = input.triangles.row(random() % 24).transpose();
      input = with_triangles(input, {{again[1], again[2], again[0]}});
    }
    for (int i = 0; i < round % 3; ++i) {
      const int v = static_cast<int>(random() % 16), w = static_cast<int>(random() % 16);
      input = with_triangles(input, {{v, w, v}});
    }
    // The order of the triangles must not matter.
    for (Eigen::Index t = input.triangles.rows() - 1; t > 0; --t) {
      input.triangles.row(t).swap(input.triangles.row(static_cast<Eigen::Index>(random() % (t + 1))));
    }
    const SourceMesh source = sanitized(input);
    EXPECT_EQ(source.solid, Solid::closed) << round;
    EXPECT_NEAR(source.volume, 63, 1e-12) << round;
  }
}

}  // namespace
}  // namespace encage
