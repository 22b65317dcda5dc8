// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/count_allocations.h"
#include "oracles/exact_pair.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/broadphase/shape/stored_samples.h"

#include <encage/error.h>
#include <encage/self.h>
#include <encage/shape_cache.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

constexpr double endless = std::numeric_limits<double>::infinity();

struct Found {
  int shared;
  bool proven;
};
using AllFound = std::map<std::pair<int, int>, Found>;

AllFound all_found(const Shape& shape) {
  AllFound all;
  const VisitEnd end = for_each_self_intersection(shape, {}, [&](const SelfIntersection& found) {
    EXPECT_LT(found.triangles.a, found.triangles.b);
    const bool once =
        all.emplace(std::pair(found.triangles.a, found.triangles.b), Found{found.shared, found.proven}).second;
    EXPECT_TRUE(once);
    return true;
  });
  EXPECT_EQ(end, VisitEnd::complete);
  return all;
}

// ---- The twin ----------------------------------------------------------------

/// The vertices of a triangle, each once, that are in another one, or are not.
std::vector<std::int32_t> vertices_of(const TriangleMesh& mesh, std::int64_t t, std::int64_t other, bool shared) {
  std::vector<std::int32_t> all;
  const auto row = mesh.triangles.row(other);
  for (int k = 0; k < 3; ++k) {
    const std::int32_t v = mesh.triangles(t, k);
    const bool is_shared = v == row[0] || v == row[1] || v == row[2];
    if (is_shared == shared && std::ranges::find(all, v) == all.end()) all.push_back(v);
  }
  return all;
}

/// Whether two triangles have more in common than vertices and edges that they share. Exact, if the coordinates are
/// small integers.
bool meet_beyond(const TriangleMesh& mesh, std::int64_t i, std::int64_t j) {
  const Corners a = {mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2)};
  const Corners b = {mesh.corner(j, 0), mesh.corner(j, 1), mesh.corner(j, 2)};
  const auto shared = vertices_of(mesh, i, j, true), of_a = vertices_of(mesh, i, j, false),
             of_b = vertices_of(mesh, j, i, false);
  if (shared.empty()) return triangles_meet(a, b, 0);
  if (of_a.empty() || of_b.empty()) return shared.size() == 3;
  const auto edge = [&](const std::vector<std::int32_t>& of) -> Corners {
    return {mesh.vertex(of.front()), mesh.vertex(of.back()), mesh.vertex(of.back())};
  };
  if (shared.size() == 1) return triangles_meet(edge(of_a), b, 0) || triangles_meet(a, edge(of_b), 0);
  const Vector origin = mesh.vertex(shared[0]), u = mesh.vertex(shared[1]) - origin, p = mesh.vertex(of_a[0]) - origin,
               q = mesh.vertex(of_b[0]) - origin;
  return u.dot(p.cross(q)) == 0 && u.cross(p).dot(u.cross(q)) > 0;
}

bool is_degenerate(const TriangleMesh& mesh, std::int64_t t) {
  return (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm() == 0;
}

/// Triangles between points of a small lattice, some of them twice.
TriangleMesh lattice_soup(shapes::Random& random, int points, int count, int size) {
  std::vector<std::array<double, 3>> v;
  for (int i = 0; i < points; ++i) {
    v.push_back({1.0 * random.integer(size), 1.0 * random.integer(size), 1.0 * random.integer(size)});
  }
  std::vector<std::array<std::int32_t, 3>> t;
  for (int i = 0; i < count; ++i) {
    t.push_back({random.integer(points), random.integer(points), random.integer(points)});
    if (random.integer(16) == 0) t.push_back({t.back()[1], t.back()[0], t.back()[2]});
  }
  return shapes::mesh(v, t);
}

void expect_all_found(const TriangleMesh& mesh, std::array<int, 4>& meeting, std::array<int, 4>& apart, int& proven) {
  const AllFound all = all_found(*make_shape(mesh));
  bool any = false, any_proven = false;
  for (std::int32_t i = 0; i < mesh.triangles.rows(); ++i) {
    for (std::int32_t j = i + 1; j < mesh.triangles.rows(); ++j) {
      const auto shared = vertices_of(mesh, i, j, true).size();
      const auto found = all.find({i, j});
      const bool truth = meet_beyond(mesh, i, j);
      ++(truth ? meeting : apart)[shared];
      if (found == all.end()) {
        EXPECT_FALSE(truth) << "missed: " << i << ", " << j;
        continue;
      }
      any = true;
      EXPECT_EQ(found->second.shared, static_cast<int>(shared));
      if (found->second.proven) {
        EXPECT_TRUE(truth) << i << ", " << j;
        any_proven = true;
        ++proven;
      }
      if (!truth) {
        EXPECT_TRUE(is_degenerate(mesh, i) || is_degenerate(mesh, j)) << i << ", " << j;
      }
    }
  }
  const SelfResult result = self_intersects(*make_shape(mesh));
  EXPECT_EQ(result.answer, any_proven ? SelfAnswer::crossing : any ? SelfAnswer::touching : SelfAnswer::free);
  if (any) {
    EXPECT_TRUE(all.contains({result.first.triangles.a, result.first.triangles.b}));
  }
}

TEST(SelfIntersections, AreThoseOfExactArithmetic) {
  shapes::Random random(1);
  std::array<int, 4> meeting{}, apart{};
  int proven = 0;
  for (int round = 0; round < 150; ++round) {
    SCOPED_TRACE(round);
    // Few points make triangles share them; many make most triangles strangers.
    const int points = std::vector{8, 14, 40}[static_cast<std::size_t>(random.integer(3))];
    expect_all_found(
        lattice_soup(random, points, 24, std::vector{3, 6, 40}[static_cast<std::size_t>(random.integer(3))]), meeting,
        apart, proven);
  }
  for (const int shared : {0, 1, 2, 3}) EXPECT_GT(meeting[static_cast<std::size_t>(shared)], 50) << shared;
  for (const int shared : {0, 1, 2}) EXPECT_GT(apart[static_cast<std::size_t>(shared)], 50) << shared;
  EXPECT_GT(proven, 1000);
}

TEST(SelfIntersections, ThereAreNoneInCleanMeshes) {
  const std::vector<TriangleMesh> clean = {
      shapes::box({-1, -2, -3}, {1, 2, 3}), shapes::sphere(4), shapes::torus(1, 0.4, 60, 30),
      shapes::joined(shapes::sphere(2), shapes::scaled(shapes::sphere(2), 0.5)), sheet(12, 2, 1)};
  for (const TriangleMesh& mesh : clean) {
    for (const double scale : {1e-30, 1e-3, 1.0, 1e30}) {
      const ShapePtr shape = make_shape(shapes::scaled(mesh, scale));
      EXPECT_TRUE(all_found(*shape).empty());
      EXPECT_EQ(self_intersects(*shape).answer, SelfAnswer::free);
      EXPECT_EQ(self_distance(*shape).neighbours.a, -1);
    }
  }
}

TEST(SelfIntersections, OfKnownKinds) {
  const auto answer = [](const TriangleMesh& mesh) { return self_intersects(*make_shape(mesh)).answer; };
  const TriangleMesh plane = sheet(6, 2, 1);
  const TriangleMesh upright = shapes::moved(sheet(5, 0, 1), {0.1, 0.03, 0.02});
  EXPECT_EQ(answer(shapes::joined(plane, upright)), SelfAnswer::crossing);
  EXPECT_EQ(answer(shapes::joined(plane, shapes::moved(plane, {0, 0, 1e-3}))), SelfAnswer::free);
  EXPECT_EQ(answer(shapes::joined(plane, plane)), SelfAnswer::touching) << "one sheet twice, with vertices of its own";
  EXPECT_EQ(answer(shapes::joined(plane, shapes::moved(plane, {0.3, 0.1, 0}))), SelfAnswer::touching);
  const TriangleMesh box = shapes::box({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(answer(shapes::joined(box, shapes::moved(box, {1, 1, 0}))), SelfAnswer::touching) << "along an edge";
  EXPECT_EQ(answer(shapes::joined(box, shapes::moved(box, {1, 1, 1}))), SelfAnswer::touching) << "in a vertex";
  EXPECT_EQ(answer(shapes::joined(box, shapes::moved(box, {0.5, 0.25, 0.125}))), SelfAnswer::crossing);
  const std::vector<std::array<double, 3>> square = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.75, 0}, {1, 1, 0}};
  EXPECT_EQ(answer(shapes::mesh(square, {{0, 1, 2}, {0, 1, 2}})), SelfAnswer::crossing) << "one triangle twice";
  EXPECT_EQ(answer(shapes::mesh(square, {{0, 1, 2}, {1, 0, 3}})), SelfAnswer::touching) << "folded over";
  EXPECT_EQ(answer(shapes::mesh(square, {{0, 1, 2}, {2, 1, 4}})), SelfAnswer::free) << "two halves of a square";
  EXPECT_EQ(answer(shapes::mesh(square, {{0, 1, 2}})), SelfAnswer::free);
}

TEST(SelfIntersections, EndWithTheirBudgetAndSaySo) {
  // Pairs of one triangle, many times, are all there are.
  const TriangleMesh pile =
      shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<std::array<std::int32_t, 3>>(300, {0, 1, 2}));
  const ShapePtr shapes_of[] = {make_shape(pile), make_shape(shapes::joined(sheet(6, 2, 1), sheet(9, 0, 1)))};
  int exhausted = 0, complete = 0;
  for (const ShapePtr& shape : shapes_of) {
    std::vector<std::pair<int, int>> all, found;
    const auto visit = [&](std::int64_t steps, std::vector<std::pair<int, int>>& list, std::size_t most) {
      list.clear();
      return for_each_self_intersection(*shape, {.most_steps = steps}, [&](const SelfIntersection& pair) {
        list.emplace_back(pair.triangles.a, pair.triangles.b);
        return list.size() < most;
      });
    };
    constexpr std::size_t any = std::numeric_limits<std::size_t>::max();
    EXPECT_EQ(visit(std::int64_t{1} << 40, all, any), VisitEnd::complete);
    EXPECT_EQ(visit(std::int64_t{1} << 40, found, 1), VisitEnd::stopped);
    EXPECT_EQ(found.size(), 1U);
    for (const std::int64_t steps : {0, 1, 20, 300, 5000, 100'000, 10'000'000}) {
      SCOPED_TRACE(steps);
      const VisitEnd end = visit(steps, found, any);
      ASSERT_LE(found.size(), all.size());
      EXPECT_TRUE(std::equal(found.begin(), found.end(), all.begin()));
      EXPECT_LE(static_cast<std::int64_t>(found.size()), steps / 8 + 1);
      if (end == VisitEnd::complete) {
        EXPECT_EQ(found.size(), all.size());
      }
      EXPECT_NE(end, VisitEnd::stopped);
      ++(end == VisitEnd::complete ? complete : exhausted);
      const SelfDistance whole = self_distance(*shape), part = self_distance(*shape, {.most_steps = steps});
      EXPECT_LE(part.lower, whole.upper);
      EXPECT_GE(part.upper, whole.lower);
      if (!part.exhausted) {
        EXPECT_EQ(part.lower, whole.lower);
        EXPECT_EQ(part.upper, whole.upper);
      }
    }
  }
  EXPECT_GT(exhausted, 5);
  EXPECT_GT(complete, 2);
  const ShapePtr ball = make_shape(shapes::sphere(3));
  EXPECT_EQ(self_intersects(*ball, {.most_steps = 100}).answer, SelfAnswer::unknown);
  EXPECT_EQ(self_intersects(*ball, {.most_steps = 200 * 1280}).answer, SelfAnswer::free);
}

// ---- Distances ---------------------------------------------------------------

/// The least distance of triangles that share no vertex, in long double.
Real least_self_distance(const TriangleMesh& mesh) {
  const auto t = at_time(mesh, Vector::Zero(), {}, 0);
  Real least = endless;
  for (std::size_t i = 0; i < t.size(); ++i) {
    for (std::size_t j = i + 1; j < t.size(); ++j) {
      if (!(distance_bound(t[i], t[j]) < least)) continue;
      if (vertices_of(mesh, static_cast<std::int64_t>(i), static_cast<std::int64_t>(j), true).empty()) {
        least = std::min(least, triangle_distance(t[i], t[j]));
      }
    }
  }
  return least;
}

TriangleMesh rounded(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

void expect_distance(const TriangleMesh& mesh, int& touching, int& apart) {
  const ShapePtr shape = make_shape(mesh);
  const Real truth = least_self_distance(mesh);
  const SelfDistance found = self_distance(*shape);
  EXPECT_FALSE(found.exhausted);
  EXPECT_LE(found.lower, truth);
  EXPECT_GE(found.upper, truth);
  if (found.triangles.a < 0) {
    EXPECT_EQ(truth, endless);
    return;
  }
  ++(truth > 0 ? apart : touching);
  const double size = mesh.vertices.cwiseAbs().maxCoeff();
  EXPECT_LE(found.upper - found.lower, 1e-12 * size);
  EXPECT_LT(found.triangles.a, found.triangles.b);
  EXPECT_LE((found.point_a - found.point_b).norm(), found.upper + 1e-14 * size);
  const auto t = at_time(mesh, Vector::Zero(), {}, 0);
  EXPECT_LE(point_triangle_distance(found.point_a.cast<Real>(), t[static_cast<std::size_t>(found.triangles.a)]),
            1e-14 * size);
  EXPECT_LE(point_triangle_distance(found.point_b.cast<Real>(), t[static_cast<std::size_t>(found.triangles.b)]),
            1e-14 * size);
  // Tolerances and limits.
  const SelfDistance loose = self_distance(*shape, {.tolerance = 0.1});
  EXPECT_LE(loose.lower, truth);
  EXPECT_GE(loose.upper, truth);
  EXPECT_LE(loose.upper, 1.1 * found.upper * (1 + 1e-9));
  if (!(truth > 0)) return;
  const SelfDistance below = self_distance(*shape, {.limit = 0.5 * found.lower}),
                     above = self_distance(*shape, {.limit = 2 * found.upper});
  EXPECT_EQ(below.lower, 0.5 * found.lower);
  EXPECT_EQ(below.upper, endless);
  EXPECT_EQ(below.triangles.a, -1);
  EXPECT_EQ(above.lower, found.lower);
  EXPECT_EQ(above.upper, found.upper);
}

TEST(SelfDistances, HoldAgainstAllPairs) {
  shapes::Random random(3);
  int touching = 0, apart = 0;
  for (int round = 0; round < 60; ++round) {
    SCOPED_TRACE(round);
    const TriangleMesh soup = lattice_soup(random, 16, round % 2 == 0 ? 8 : 3, 60);
    bool degenerate = false;
    for (std::int64_t t = 0; t < soup.triangles.rows(); ++t) degenerate = degenerate || is_degenerate(soup, t);
    if (!degenerate) expect_distance(soup, touching, apart);
  }
  for (const TriangleMesh& mesh :
       {shapes::sphere(2), shapes::torus(1, 0.3, 24, 12), sheet(5, 1, 1), shapes::box({0, 0, 0}, {1, 2, 3}),
        shapes::joined(shapes::sphere(2), shapes::moved(shapes::sphere(2), {2.01, 0, 0})),
        shapes::scaled(shapes::torus(1, 0.3, 24, 12), 1e-20), shapes::scaled(shapes::torus(1, 0.3, 24, 12), 1e20)}) {
    expect_distance(rounded(mesh), touching, apart);
  }
  for (const Body& body : sample_bodies()) {
    if (!body.has_fine()) continue;
    SCOPED_TRACE(body.sample.name);
    const SelfDistance found = self_distance(*body.shape);
    const Real truth = least_self_distance(body.mesh());
    EXPECT_LE(found.lower, truth);
    EXPECT_GE(found.upper, truth);
  }
  EXPECT_GT(touching, 10);
  EXPECT_GT(apart, 10);
}

TEST(SelfDistances, OfCompoundsAreThoseOfTheirParts) {
  const TriangleMesh ring = rounded(shapes::torus(1, 0.3, 24, 12));
  const TriangleMesh crossing = shapes::joined(sheet(2, 2, 1), shapes::moved(sheet(1, 0, 1), {0.1, 0.03, 0.02}));
  const std::vector<CompoundPart> parts = {{make_shape(ring), shift(5), 0.5}, {make_shape(ring), shift(5.1)}};
  const ShapePtr compound = make_compound(parts);
  EXPECT_EQ(self_intersects(*compound).answer, SelfAnswer::free) << "though the parts overlap";
  const SelfDistance one = self_distance(*make_shape(ring)), both = self_distance(*compound);
  EXPECT_NEAR(both.lower, 0.5 * one.lower, 1e-9);
  EXPECT_NEAR(both.upper, 0.5 * one.upper, 1e-9);
  EXPECT_LE(both.lower, 0.5 * one.upper);
  EXPECT_NEAR((both.point_a - Vector(5, 0, 0)).norm(), (0.5 * one.point_a).norm(), 1e-9);
  std::vector<CompoundPart> more = parts;
  more.push_back({make_shape(crossing), shift(9), 3});
  const SelfResult result = self_intersects(*make_compound(more));
  EXPECT_EQ(result.answer, SelfAnswer::crossing);
  EXPECT_GE(result.first.triangles.a, 2 * ring.triangles.rows());
  EXPECT_EQ(self_distance(*make_compound(more)).lower, 0);
  EXPECT_GE(self_distance(*make_compound(more)).triangles.a, 2 * ring.triangles.rows());
}

TEST(SelfDistances, NameNeighboursThatMeet) {
  const std::vector<std::array<double, 3>> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.75, 0}, {5, 5, 5}};
  const SelfDistance folded = self_distance(*make_shape(shapes::mesh(points, {{0, 1, 2}, {0, 1, 4}, {1, 0, 3}})));
  EXPECT_EQ(folded.neighbours.a, 0);
  EXPECT_EQ(folded.neighbours.b, 2);
  EXPECT_FALSE(folded.neighbours_proven);
  EXPECT_EQ(folded.upper, endless) << "all share vertices";
  const SelfDistance twice = self_distance(*make_shape(shapes::mesh(points, {{0, 1, 2}, {0, 1, 2}})));
  EXPECT_TRUE(twice.neighbours_proven);
}

// ---- Input -------------------------------------------------------------------

std::string error_of_visits(const Shape& shape, const SelfOptions& options = {}) {
  try {
    EXPECT_EQ(for_each_self_intersection(shape, options, [](const SelfIntersection&) { return true; }),
              VisitEnd::complete);
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

TEST(SelfInput, WithoutAFineMeshNothingIsKnown) {
  const std::vector<Body> all = sample_bodies();
  const Body &box = find(all, "box"), cages(without_fine(box.sample));
  const std::vector<CompoundPart> parts = {{box.shape}, {cages.shape, shift(9)}};
  for (const ShapePtr& shape : {cages.shape, make_compound(parts)}) {
    EXPECT_EQ(error_of_visits(*shape), "self-intersections: the shape or a part of it has no fine mesh");
    EXPECT_EQ(self_intersects(*shape).answer, SelfAnswer::unknown);
    EXPECT_EQ(self_distance(*shape).lower, 0);
    EXPECT_EQ(self_distance(*shape).upper, endless);
  }
  EXPECT_EQ(error_of_visits(*box.shape), "none");
  EXPECT_EQ(error_of_visits(*box.shape, {.most_steps = -1}), "self-intersections: most_steps is -1, below 0");
  EXPECT_EQ(self_intersects(*box.shape, {.most_steps = -1}).answer, SelfAnswer::unknown);
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SelfDistanceOptions& options :
       {SelfDistanceOptions{.limit = 0}, SelfDistanceOptions{.limit = nan}, SelfDistanceOptions{.tolerance = -1},
        SelfDistanceOptions{.tolerance = nan}, SelfDistanceOptions{.most_steps = -1}}) {
    const SelfDistance found = self_distance(*box.shape, options);
    EXPECT_EQ(found.lower, 0);
    EXPECT_EQ(found.upper, endless);
  }
}

TEST(SelfInput, MeshesOnDemand) {
  const StoredSamples stored;
  ShapeCache cache({.budget_bytes = stored.room_for_a_pair(), .mode = LoadMode::copy});
  for (const auto& file : stored.files) {
    const ShapePtr cached = cache.load(file), loaded = load_shape(file, {}, LoadMode::copy);
    EXPECT_EQ(self_intersects(*cached).answer, self_intersects(*loaded).answer);
    EXPECT_EQ(all_found(*cached).size(), all_found(*loaded).size());
    EXPECT_EQ(self_distance(*cached).upper, self_distance(*loaded).upper);
  }
  ShapeCache whole({.budget_bytes = std::int64_t{1} << 40, .mode = LoadMode::copy});
  const ShapePtr lost = whole.load(stored.files.front());
  std::filesystem::resize_file(stored.files.front(), std::filesystem::file_size(stored.files.front()) / 2);
  EXPECT_EQ(self_intersects(*lost).answer, SelfAnswer::unknown);
  EXPECT_EQ(self_distance(*lost).upper, endless);
  EXPECT_NE(error_of_visits(*lost), "none");
}

TEST(SelfInput, QueriesDoNotAllocate) {
  const ShapePtr ring = make_shape(shapes::torus(1, 0.3, 24, 12));
  int count = 0;
  const long before = allocations;
  const VisitEnd end = for_each_self_intersection(*ring, {}, [&](const SelfIntersection&) { return ++count > 0; });
  const double sum = self_distance(*ring).lower + (self_intersects(*ring).answer == SelfAnswer::free ? 1 : 0);
  EXPECT_EQ(allocations, before);
  EXPECT_EQ(end, VisitEnd::complete);
  EXPECT_EQ(count, 0);
  EXPECT_GT(sum, 1);
}

}  // namespace
}  // namespace encage::test
