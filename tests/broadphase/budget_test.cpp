// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/distance/surface_distance.h"
#include "broadphase/separation/surface_pair.h"
#include "oracles/body.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"

#include <encage/contact.h>
#include <encage/distance.h>
#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

// Queries whose work would explode: very many triangles that touch at once, are equally near or stay near each other.
// Steps are counted, no time is taken.
namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

constexpr std::int64_t unlimited = std::numeric_limits<std::int64_t>::max() / 2;

/// One triangle, many times.
TriangleMesh stack(int count) {
  return shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                      std::vector<std::array<std::int32_t, 3>>(static_cast<std::size_t>(count), {0, 1, 2}));
}

/// A flat square of size 2 x 2 with its centre at the origin.
TriangleMesh sheet(int cells) {
  std::vector<std::array<double, 3>> v;
  std::vector<std::array<std::int32_t, 3>> t;
  for (int j = 0; j <= cells; ++j) {
    for (int i = 0; i <= cells; ++i) v.push_back({2.0 * i / cells - 1, 2.0 * j / cells - 1, 0});
  }
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      const int a = j * (cells + 1) + i, b = a + cells + 1;
      t.push_back({a, a + 1, b + 1});
      t.push_back({a, b + 1, b});
    }
  }
  return shapes::mesh(v, t);
}

/// Triangles around an apex at the origin, rising to z = 1.
TriangleMesh fan(int count) {
  std::vector<std::array<double, 3>> v = {{0, 0, 0}};
  std::vector<std::array<std::int32_t, 3>> t;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    v.push_back({std::cos(angle), std::sin(angle), 1});
    t.push_back({0, 1 + i, 1 + (i + 1) % count});
  }
  return shapes::mesh(v, t);
}

/// Narrow strips of length 1 along the x axis, or along the y axis.
TriangleMesh strips(int count, bool along_x) {
  std::vector<std::array<double, 3>> v;
  std::vector<std::array<std::int32_t, 3>> t;
  for (int i = 0; i <= count; ++i) {
    for (const double end : {0.0, 1.0}) {
      const double across = static_cast<double>(i) / count;
      v.push_back(along_x ? std::array{end, across, 0.0} : std::array{across, end, 0.0});
    }
  }
  for (int i = 0; i < count; ++i) {
    t.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    t.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  return shapes::mesh(v, t);
}

ShapePtr hollow(const TriangleMesh& mesh) { return make_shape(mesh, {.hollow = true}); }

Pose turned(const Vector& axis, double degrees, const Vector& to = Vector::Zero()) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()).toRotationMatrix();
  pose.translation() = to;
  return pose;
}

struct Case {
  std::string name;
  ShapePtr a;
  Motion motion_a;
  ShapePtr b;
  Motion motion_b = Motion::resting(Pose::Identity());
  double margin = 0, arc = 0;

  Verdict ask_separated(std::int64_t steps) const {
    return separated(*a, motion_a, *b, motion_b, PairOptions{.margin = margin + arc, .most_steps = steps});
  }
  DistanceResult ask_distance(std::int64_t steps) const {
    return distance(*a, motion_a, *b, motion_b, {.most_steps = steps});
  }
  std::optional<Contact> ask_contact(std::int64_t steps) const {
    return first_contact(*a, motion_a, *b, motion_b, {.margin = margin, .arc = arc, .most_steps = steps});
  }
};

/// `size` is about the number of triangles of each body.
std::vector<Case> hard_cases(int size) {
  const int root = static_cast<int>(std::sqrt(0.5 * size));
  const ShapePtr pile = hollow(stack(size)), plane = hollow(sheet(root)), cone = hollow(fan(size)),
                 rows = hollow(strips(size / 2, true)), columns = hollow(strips(size / 2, false)),
                 ball = make_shape(shapes::torus(1, 0.4, root, root)),
                 thick = hollow(shapes::joined(sheet(root), sheet(root)));
  const auto rest = [](const Pose& pose) { return Motion::resting(pose); };
  const Pose upside_down = turned(Vector::UnitX(), 180 - 1e-7);
  return {
      {"coincident triangles above each other", pile, rest(shift(0, 0, 0.01)), pile},
      {"coincident triangles a hair above each other", pile, rest(shift(0, 0, 1e-6)), pile},
      {"coincident triangles in the same place", pile, rest(shift(0, 0, 0)), pile},
      {"coincident triangles that cross", pile, rest(turned({1, 2, 3}, 30, {0, 0, 0.01})), pile},
      {"coincident triangles that fall", pile, {shift(0, 0, 0.75), shift(0.125, 0, -0.25)}, pile},
      {"coincident triangles within the margin", pile, rest(shift(0, 0, 0.01)), pile, rest(shift(0)), 0.02},
      {"parallel sheets", plane, rest(turned(Vector::UnitZ(), 20, {0.3, 0.2, 0.5})), plane},
      {"sheets that fall", plane, {shift(0.003, 0.004, 0.75), shift(0.003, 0.004, -0.25)}, plane},
      {"sheets that slide", plane, {shift(0, 0, 1e-6), shift(0.1, 0, 1e-6)}, plane},
      {"sheets that turn", plane, {shift(0, 0, 1e-6), turned(Vector::UnitZ(), 20, {0, 0, 1e-6})}, plane},
      {"doubled sheets in the same place", thick, rest(shift(0)), thick},
      {"bodies in the same place", ball, rest(shift(0)), ball},
      {"bodies nearly in the same place", ball, rest(shift(1e-6, 2e-6, 5e-7)), ball},
      {"apex to apex", cone, rest(shift(0, 0, 1e-6)), cone, rest(upside_down)},
      {"apex onto apex", cone, {shift(0, 0, 0.75), shift(0, 0, -0.25)}, cone, rest(upside_down)},
      {"cone in cone", cone, rest(shift(0, 0, 1e-3)), cone},
      {"strips across strips", rows, rest(shift(0, 0, 1e-6)), columns},
      {"strips onto strips", rows, {shift(0, 0, 0.75), shift(0, 0, -0.25)}, columns},
      {"a turn, with its arcs",
       ball,
       {shift(2.9, 0, 0.2), turned({1, 2, 3}, 60, {2.9, 0, 0.2})},
       ball,
       rest(shift(0)),
       0,
       0.2},
      {"a turn, with arcs that touch",
       ball,
       {shift(2.9, 0, 0.2), turned({1, 2, 3}, 60, {2.9, 0, 0.2})},
       ball,
       rest(shift(0)),
       0,
       0.9},
  };
}

/// Scenes of samples, near each other or overlapping.
std::vector<Case> usual_cases(const std::vector<Body>& all) {
  shapes::Random random(3);
  std::vector<Case> cases;
  for (int i = 0; i < 60; ++i) {
    const Body &a = all[random.integer(static_cast<int>(all.size()))],
               &b = all[random.integer(static_cast<int>(all.size()))];
    if (!a.has_fine() || !b.has_fine()) continue;
    const Pose pose_b = random_pose(random, 0);
    Pose pose_a = random_pose(random, 0);
    pose_a.translation() = random_direction(random) * random(0.2, 1) * 0.5 * (a.diagonal() + b.diagonal());
    const Motion motion = random_motion(random, pose_a, 0.8, 0.3 * a.diagonal());
    cases.push_back({a.sample.name + ", " + b.sample.name, a.shape, motion, b.shape, Motion::resting(pose_b),
                     random.integer(2) * 0.02, random.integer(2) * 0.02});
  }
  return cases;
}

void expect_conservative(const Case& scene, const std::vector<std::int64_t>& budgets, int& exhausted, int& complete) {
  SCOPED_TRACE(scene.name);
  const Verdict verdict = scene.ask_separated(unlimited);
  const DistanceResult whole = scene.ask_distance(unlimited);
  const auto contact = scene.ask_contact(unlimited);
  EXPECT_FALSE(verdict.exhausted || whole.exhausted || (contact && contact->exhausted));
  for (const std::int64_t steps : budgets) {
    SCOPED_TRACE(steps);
    const Verdict v = scene.ask_separated(steps);
    if (v.exhausted) {
      EXPECT_FALSE(v.separated);
    } else {
      EXPECT_EQ(v.separated, verdict.separated);
    }
    const DistanceResult d = scene.ask_distance(steps);
    EXPECT_GE(d.lower, 0);
    EXPECT_LE(d.lower, whole.upper);
    EXPECT_GE(d.upper, whole.lower);
    if (!d.exhausted) {
      EXPECT_EQ(d.lower, whole.lower);
      EXPECT_EQ(d.upper, whole.upper);
    }
    const auto c = scene.ask_contact(steps);
    ASSERT_TRUE(c || !contact);
    if (c && contact) {
      EXPECT_LE(c->time, contact->time);
    }
    if (c && c->exhausted) {
      EXPECT_GE(c->time, 0);
      EXPECT_NEAR(c->normal.norm(), 1, 1e-9);
      for (const std::int32_t vertex : c->vertices) EXPECT_GE(vertex, 0);
    } else {
      ASSERT_EQ(c.has_value(), contact.has_value());
      if (c) {
        EXPECT_EQ(c->time, contact->time);
        EXPECT_EQ(c->kind, contact->kind);
        EXPECT_EQ(c->vertices, contact->vertices);
        EXPECT_EQ(c->overlapping, contact->overlapping);
      }
    }
    for (const bool end : {v.exhausted, d.exhausted, c && c->exhausted}) ++(end ? exhausted : complete);
  }
}

TEST(Budgets, EndHardQueriesConservatively) {
  int exhausted = 0, complete = 0;
  for (const Case& scene : hard_cases(240)) {
    expect_conservative(scene, {0, 1, 30, 1000, 1 << 12, 1 << 14, 1 << 17}, exhausted, complete);
  }
  EXPECT_GT(exhausted, 60);
  EXPECT_GT(complete, 60);
}

TEST(Budgets, EndUsualQueriesConservatively) {
  const std::vector<Body> all = sample_bodies();
  int exhausted = 0, complete = 0;
  for (const Case& scene : usual_cases(all)) {
    expect_conservative(scene, {0, 3, 50, 300, 2000, 1 << 20}, exhausted, complete);
  }
  EXPECT_GT(exhausted, 100);
  EXPECT_GT(complete, 100);
}

/// A path that does not count its steps takes more than the budget of what is counted, and reports none.
TEST(Budgets, AreKept) {
  for (const Case& scene : hard_cases(2000)) {
    SCOPED_TRACE(scene.name);
    const SimpleShape &a = scene.a->simple(), &b = scene.b->simple();
    const ScaledSurface fine_a(a.fine, 1), fine_b(b.fine, 1);
    const std::int64_t budget = 1 << 15;
    std::int64_t steps = budget;
    const RestingPair pair(a.frame, scene.motion_a, b.frame, scene.motion_b);
    surface_distance(fine_a, fine_b, pair, {.steps = &steps});
    // A leaf is finished, in each of three searches.
    EXPECT_GT(steps, -3 * 64 * 30);
    steps = budget;
    surfaces_apart(fine_a, fine_b, pair_motion(a.frame, scene.motion_a, b.frame, scene.motion_b), 1e-9, &steps);
    EXPECT_GT(steps, -256 * 16 - 10);
  }
}

TEST(Budgets, LeaveContactsAtNearlyTheirTime) {
  for (const Case& scene : hard_cases(4000)) {
    SCOPED_TRACE(scene.name);
    const auto contact = scene.ask_contact(1 << 18);
    if (scene.motion_a.start.translation().z() != 0.75) continue;
    ASSERT_TRUE(contact);
    EXPECT_LE(contact->time, 0.75);
    EXPECT_GT(contact->time, 0.75 - 0x1p-13);
    EXPECT_GT(std::abs(contact->normal.z()), 0.5);
  }
}

TEST(Budgets, LastForTurnsWithArcs) {
  const ShapePtr ring = make_shape(shapes::torus(1, 0.4, 120, 60));
  for (const double degrees : {20.0, 45.0, 60.0, 100.0, 150.0}) {
    SCOPED_TRACE(degrees);
    const Pose start = turned({3, 1, 2}, 20);
    const Motion motion{start, Pose(start * turned({1, 2, 3}, degrees))}, rest = Motion::resting(shift(3.1, 0, 0.2));
    const auto contact =
        first_contact(*ring, motion, *ring, rest, {.arc = arc_margin(*ring, motion), .most_steps = 1 << 17});
    EXPECT_FALSE(contact && contact->exhausted);
    const auto straight = first_contact(*ring, motion, *ring, rest, {.most_steps = 1 << 14});
    EXPECT_FALSE(straight);
  }
}

/// Visits until the budget ends, or until `most` pairs have been visited.
VisitEnd visit_pairs(const Case& scene, std::int64_t steps, std::vector<std::pair<int, int>>& visited,
                     std::size_t most = std::numeric_limits<std::size_t>::max()) {
  visited.clear();
  return for_each_triangle_pair(*scene.a, scene.motion_a, *scene.b, scene.motion_b,
                                TrianglePairOptions{.margin = scene.margin, .most_steps = steps},
                                [&](TrianglePair pair) {
                                  visited.emplace_back(pair.a, pair.b);
                                  return visited.size() < most;
                                });
}

TEST(Budgets, EndVisitsOfTrianglePairsAndSaySo) {
  int exhausted = 0, complete = 0;
  for (const Case& scene : hard_cases(120)) {
    SCOPED_TRACE(scene.name);
    std::vector<std::pair<int, int>> all, visited;
    EXPECT_TRUE(for_each_triangle_pair(*scene.a, scene.motion_a, *scene.b, scene.motion_b, scene.margin,
                                       [&](TrianglePair pair) {
                                         all.emplace_back(pair.a, pair.b);
                                         return true;
                                       }));
    EXPECT_EQ(visit_pairs(scene, unlimited, visited), VisitEnd::complete);
    EXPECT_EQ(visited, all);
    for (const std::int64_t steps : {0, 1, 30, 1000, 1 << 13, 1 << 16, 1 << 20}) {
      SCOPED_TRACE(steps);
      const VisitEnd end = visit_pairs(scene, steps, visited);
      ASSERT_LE(visited.size(), all.size());
      EXPECT_TRUE(std::equal(visited.begin(), visited.end(), all.begin())) << "the first ones";
      EXPECT_LE(static_cast<std::int64_t>(visited.size()), steps / 16 + 2) << "a pair takes 16 steps";
      if (end == VisitEnd::complete) {
        EXPECT_EQ(visited.size(), all.size());
        ++complete;
      } else {
        EXPECT_EQ(end, VisitEnd::exhausted);
        ++exhausted;
      }
    }
    if (!all.empty()) {
      EXPECT_EQ(visit_pairs(scene, unlimited, visited, 1), VisitEnd::stopped);
      EXPECT_EQ(visited.size(), 1U);
    }
  }
  EXPECT_GT(exhausted, 30);
  EXPECT_GT(complete, 30);
}

TEST(Budgets, OfTrianglePairsAreNotNegative) {
  const ShapePtr pile = hollow(stack(2));
  const auto visit = [](TrianglePair) { return true; };
  std::string message = "none";
  try {
    const VisitEnd end = for_each_triangle_pair(*pile, {}, *pile, {}, TrianglePairOptions{.most_steps = -1}, visit);
    EXPECT_EQ(end, VisitEnd::complete);
  } catch (const Error& error) {
    message = error.what();
  }
  EXPECT_EQ(message, "triangle pairs: most_steps is -1, below 0");
}

TEST(Budgets, OfTrianglePairsEndByDefault) {
  const ShapePtr pile = hollow(stack(6400));  // 41 million pairs touch
  std::int64_t visited = 0;
  EXPECT_EQ(for_each_triangle_pair(*pile, {}, *pile, {}, TrianglePairOptions{},
                                   [&](TrianglePair) {
                                     ++visited;
                                     return true;
                                   }),
            VisitEnd::exhausted);
  EXPECT_GT(visited, 1 << 12);
  EXPECT_LE(visited, 1 << 16);
}

/// Pairs that are equally near need not be searched: the work grows as the number of triangles.
TEST(Budgets, LastForParallelSheets) {
  for (const int cells : {16, 32, 64}) {
    SCOPED_TRACE(cells);
    const ShapePtr plane = hollow(sheet(cells));
    const Motion rest = Motion::resting(shift(0));
    for (const double degrees : {0.0, 20.0}) {
      const Motion above = Motion::resting(turned(Vector::UnitZ(), degrees, {0.03, 0.02, 0.5}));
      const DistanceResult result = distance(*plane, above, *plane, rest, {.most_steps = 60 * cells * cells});
      EXPECT_FALSE(result.exhausted);
      EXPECT_LE(result.lower, 0.5);
      EXPECT_GE(result.upper, 0.5);
    }
  }
}

}  // namespace
}  // namespace encage::test
