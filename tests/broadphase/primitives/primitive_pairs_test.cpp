// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "tests/broadphase/contact/ask_manifold.h"
#include "tests/broadphase/primitives/true_body.h"

#include <encage/casts.h>
#include <encage/contact.h>
#include <encage/distance.h>
#include <encage/manifold.h>
#include <encage/primitives.h>
#include <encage/queries.h>
#include <encage/separated.h>
#include <encage/world.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;

/// Two bodies at rest that are `wanted` apart, or as near as they can be.
struct Placed {
  const TrueBody& a;
  const TrueBody& b;
  Motion motion_a, motion_b;
  double gap = 0;
  double size = 0;   ///< of both bodies and their distance from the origin
  double error = 0;  ///< of the truth, in the world
};

/// Bodies of which one at least is a primitive, near each other. ENCAGE_PRIMITIVE_PAIRS asks for so many times as many.
class Pairs {
 public:
  explicit Pairs(std::uint32_t seed) : random_(seed) {
    if (const char* text = std::getenv("ENCAGE_PRIMITIVE_PAIRS")) times_ = std::atoi(text);
  }

  template <class Check>
  void for_each(int count, Check&& check) {
    for (int i = 0; i < times_ * count && !testing::Test::HasFatalFailure(); ++i) {
      const TrueBody& p = primitives_[pick(primitives_.size())];
      const bool mesh = i % 2 == 0;
      const TrueBody& q = mesh ? meshes_[pick(meshes_.size())] : primitives_[pick(primitives_.size())];
      const bool swapped = i % 4 < 2;
      const TrueBody &a = swapped ? p : q, &b = swapped ? q : p;
      SCOPED_TRACE(std::to_string(i) + ": " + a.name + ", " + b.name);
      check(place(a, b, i));
    }
  }

  shapes::Random& random() { return random_; }

 private:
  std::size_t pick(std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(random_(0, static_cast<double>(count))));
  }

  Placed place(const TrueBody& a, const TrueBody& b, int i) {
    const double far = i % 3 == 0 ? 1e4 : 1, unit = std::pow(10, random_(-2, 1));
    Placed pair{a, b, {}, {}};
    pair.motion_a = Motion::resting(rigid_pose(random_, far * unit), unit);
    pair.motion_b = Motion::resting(rigid_pose(random_, 0), unit * (i % 5 == 0 ? 0.1 : 1));
    const Vector way = random_direction(random_);
    const auto gap_at = [&](double distance) {
      pair.motion_b.start.translation() = pair.motion_a.start.translation() + distance * way;
      pair.motion_b.end = pair.motion_b.start;
      return static_cast<double>(gap(at(a, pair.motion_a), at(b, pair.motion_b)));
    };
    double near = 0, apart = 20 * unit;
    const double wanted = random_(0, 1) < 0.5 ? 0 : unit * std::pow(10, random_(-8, -1));
    for (int k = 0; k < 44; ++k) {
      const double middle = 0.5 * (near + apart);
      (gap_at(middle) > wanted ? apart : near) = middle;
    }
    // Beside the place where the answer changes.
    const double off = unit * std::pow(10, random_(-14, 0)) * (random_(0, 1) < 0.5 ? -1 : 1);
    pair.gap = gap_at(apart + off);
    pair.size = unit * 4 + pair.motion_a.start.translation().norm() + pair.motion_b.start.translation().norm();
    pair.error = pair.motion_a.scale * a.error + pair.motion_b.scale * b.error;
    return pair;
  }

  shapes::Random random_;
  int times_ = 1;
  std::vector<TrueBody> primitives_ = primitives(), meshes_ = true_meshes();
};

/// What the radii, of 1 or so, cost in tightness, and what the fine errors do.
double slack_of(const Placed& p) { return 4 * p.error + 1e-12 * p.size + 4e-8 * (p.motion_a.scale + p.motion_b.scale); }

// ---- At rest -----------------------------------------------------------------

TEST(PrimitivePairs, AreSeparatedOnlyIfTheyAreApart) {
  int rejected = 0, kept = 0;
  Pairs pairs(1);
  pairs.for_each(300, [&](const Placed& p) {
    const double margin = pairs.random()(0, 1) < 0.5 ? 0 : std::max(0.0, p.gap) * pairs.random()(0.5, 1.5);
    const Verdict verdict = separated(*p.a.shape, p.motion_a, *p.b.shape, p.motion_b, margin);
    EXPECT_TRUE(verdict.usable);
    if (verdict.separated) {
      ASSERT_GT(p.gap + p.error, margin - 1e-15 * p.size);
      ++rejected;
    } else if (!p.a.unknown && !p.b.unknown) {
      ASSERT_LT(p.gap, margin * (1 + 1e-8) + slack_of(p));
      ++kept;
    }
    bool visited = false;
    for_each_triangle_pair(*p.a.shape, p.motion_a, *p.b.shape, p.motion_b, margin, [&](TrianglePair) {
      visited = true;
      return false;
    });
    // Of bodies of which one holds the other no triangles need be near.
    if (p.gap > 0 && p.gap <= margin) {
      ASSERT_TRUE(visited);
    }
  });
  EXPECT_GT(rejected, 50);
  EXPECT_GT(kept, 50);
}

TEST(PrimitivePairs, DistancesAreBounds) {
  Pairs pairs(2);
  pairs.for_each(200, [&](const Placed& p) {
    const DistanceResult found = distance(*p.a.shape, p.motion_a, *p.b.shape, p.motion_b);
    const double truth = std::max(0.0, p.gap);
    ASSERT_LE(found.lower, truth + p.error + 1e-15 * p.size);
    ASSERT_GE(found.upper, truth - p.error - 1e-15 * p.size);
    ASSERT_LE(found.lower, found.upper);
    if (!p.a.unknown && !p.b.unknown) {
      ASSERT_LE(found.upper - found.lower, slack_of(p));
    }
    ASSERT_LE((found.point_a - found.point_b).norm(), found.upper + slack_of(p));
    ASSERT_LE(cage_distance_bound(*p.a.shape, p.motion_a, *p.b.shape, p.motion_b), truth + p.error + 1e-15 * p.size);
    for (const bool first : {true, false}) {
      const TrueBody& body = first ? p.a : p.b;
      if (body.radius == 0) continue;
      // The points are on the surfaces; where these meet, within both bodies.
      const Point point = real(first ? found.point_a : found.point_b);
      const double off = static_cast<double>(signed_to(at(body, first ? p.motion_a : p.motion_b), point));
      ASSERT_LE(off, slack_of(p));
      if (found.lower > 0) {
        ASSERT_GE(off, -slack_of(p));
      }
    }
    const double limit = 0.5 * truth;
    if (!(limit > 1e-3 * p.motion_a.scale)) return;
    const DistanceResult limited = distance(*p.a.shape, p.motion_a, *p.b.shape, p.motion_b, {.limit = limit});
    ASSERT_LE(limited.lower, truth);
    if (!p.a.unknown && !p.b.unknown) {
      ASSERT_GE(limited.lower, limit - slack_of(p));
    }
  });
}

TEST(PrimitivePairs, OneInsideTheOtherTouchesIt) {
  const ShapePtr box = make_box({2, 2, 2}), mesh = make_shape(shapes::cube(2)), ball = make_sphere(5);
  const ShapePtr small[] = {make_sphere(0.1), make_capsule(0.2, 0.1), make_box({0.1, 0.1, 0.1}),
                            make_cylinder(0.1, 0.1), make_shape(shapes::tetrahedron(0.3))};
  const Motion moved = Motion::resting(shift(0.3, 0.2, 0.1));
  for (const ShapePtr& host : {box, mesh, ball}) {
    for (const ShapePtr& guest : small) {
      EXPECT_FALSE(separated(*host, {}, *guest, moved).separated);
      EXPECT_FALSE(separated(*guest, moved, *host, {}).separated);
      EXPECT_EQ(distance(*host, {}, *guest, moved).upper, 0);
      EXPECT_EQ(distance(*guest, moved, *host, {}).upper, 0);
      EXPECT_EQ(cage_distance_bound(*guest, moved, *host, {}), 0);
    }
  }
  // Nothing is inside a hollow cube, but what reaches its walls.
  const ShapePtr hollow = make_shape(shapes::cube(2), {.hollow = true});
  EXPECT_TRUE(separated(*hollow, {}, *make_sphere(1.6), moved).separated);
  EXPECT_FALSE(separated(*hollow, {}, *make_sphere(1.8), moved).separated);
}

TEST(PrimitivePairs, ACageIsComparedWithAPrimitive) {
  const std::vector<Body> bodies = sample_bodies();
  const auto caged =
      std::find_if(bodies.begin(), bodies.end(), [](const Body& b) { return level_count(*b.shape) > 0 && b.solid(); });
  ASSERT_NE(caged, bodies.end());
  const ShapePtr cage = make_shape(without_fine(caged->sample).hierarchy);
  const double reach = radius(*cage);
  for (const ShapePtr& primitive : {make_sphere(0.5), make_box({0.5, 0.3, 0.2}), make_capsule(0.3, 0.2)}) {
    const Motion far = Motion::resting(shift(reach + 0.9));
    const Verdict verdict = separated(*cage, {}, *primitive, far, PairOptions{.boxes = false});
    EXPECT_TRUE(verdict.separated);
    EXPECT_EQ(verdict.stage, Stage::cage);
    const double bound = cage_distance_bound(*cage, {}, *primitive, far, {.tolerance = 0, .finest_cage = 0});
    EXPECT_GT(bound, 0.3);
    EXPECT_LE(bound, distance(*caged->shape, {}, *primitive, far).upper);
  }
}

TEST(PrimitivePairs, CompoundsAreTheUnionOfTheirParts) {
  shapes::Random random(4);
  const std::vector<TrueBody> all = primitives();
  for (int i = 0; i < 150; ++i) {
    std::vector<CompoundPart> parts;
    std::vector<std::pair<const TrueBody*, Motion>> truth;
    const Pose pose = rigid_pose(random, 3);
    for (int k = 0; k < 5; ++k) {
      const TrueBody& part = all[static_cast<std::size_t>(random(0, 9.999))];
      parts.push_back({part.shape, rigid_pose(random, 2), random(0.2, 1)});
      truth.emplace_back(&part, Motion::resting(pose * parts.back().pose, parts.back().scale));
    }
    const ShapePtr compound = make_compound(parts);
    const TrueBody& other = all[static_cast<std::size_t>(random(0, 9.999))];
    const Motion at_other = Motion::resting(rigid_pose(random, 4));
    Real least = infinity;
    double error = other.error;
    for (const auto& [part, motion] : truth) {
      least = std::min(least, gap(at(*part, motion), at(other, at_other)));
      error = std::max(error, part->error + other.error);
    }
    const double expected = std::max(0.0, static_cast<double>(least));
    const DistanceResult found = distance(*compound, Motion::resting(pose), *other.shape, at_other);
    EXPECT_LE(found.lower, expected + error + 1e-14);
    EXPECT_GE(found.upper, expected - error - 1e-14);
    EXPECT_LE(found.upper - found.lower, 4 * error + 1e-7);
    const bool apart = separated(*compound, Motion::resting(pose), *other.shape, at_other).separated;
    if (apart) {
      EXPECT_GT(static_cast<double>(least), -error);
    }
    if (expected > 2 * error + 1e-7) {
      EXPECT_TRUE(apart);
    }
  }
}

TEST(PrimitivePairs, HalfSpacesBoundThem) {
  shapes::Random random(5);
  for (const TrueBody& body : primitives()) {
    SCOPED_TRACE(body.name);
    for (int i = 0; i < 60; ++i) {
      const Motion motion = Motion::resting(rigid_pose(random, 3), random(0.1, 2));
      const HalfSpace plane{random_direction(random), random(-1, 1)};
      Real low = infinity;
      const TruePlaced placed = at(body, motion);
      for (const RealTriangle& t : placed.triangles) {
        for (const Point& p : t) low = std::min(low, real(plane.normal).dot(p) - Real(plane.offset));
      }
      const double height = static_cast<double>(low - placed.radius);
      const double error = 1e-7 + 2 * motion.scale * body.error;
      const double margin = std::max(0.0, height + random(-2, 2) * error + (i % 2 == 0 ? 0 : random(-1, 1)));
      const bool apart = separated(*body.shape, motion, plane, margin).separated;
      if (apart) {
        EXPECT_GT(height + motion.scale * body.error, margin - 1e-14);
      }
      if (height > margin + error) {
        EXPECT_TRUE(apart);
      }
      EXPECT_EQ(overlaps(*body.shape, motion, plane), !separated(*body.shape, motion, plane).separated);
      const PlaneDistance found = distance(*body.shape, motion, plane);
      EXPECT_LE(found.lower, height + 1e-14);
      EXPECT_GE(found.upper, height - 1e-14);
      EXPECT_LT(found.upper - found.lower, 4 * error);
      EXPECT_NEAR(plane.normal.dot(found.point) - plane.offset, height, 2 * error);
      EXPECT_NEAR(plane.normal.dot(found.foot), plane.offset, 1e-12);
    }
  }
}

TEST(PrimitivePairs, VolumesAreCastAtThem) {
  shapes::Random random(9);
  for (const TrueBody& body : primitives()) {
    SCOPED_TRACE(body.name);
    for (int i = 0; i < 60; ++i) {
      const Motion motion = Motion::resting(rigid_pose(random, 3), random(0.1, 2));
      const Sphere sphere{motion.start.translation() + random(0, 6) * random_direction(random), random(0, 0.5)};
      const Vector way = motion.start.translation() + random(0, 1) * random_direction(random) - sphere.centre;
      const auto gap_at = [&](double t) {
        const TrueBody ball{.name = "ball",
                            .shape = nullptr,
                            .triangles = {{Point(0, 0, 0), Point(0, 0, 0), Point(0, 0, 0)}},
                            .radius = 1};
        Motion at_time =
            Motion::resting(Eigen::Isometry3d(Eigen::Translation3d(sphere.centre + t * way)), sphere.radius);
        return static_cast<double>(gap(at(body, motion), at(ball, at_time)));
      };
      const double error = 1e-7 + 2 * motion.scale * body.error;
      const CastResult found = cast(*body.shape, motion, sphere, way);
      ASSERT_NE(found.answer, CastAnswer::unknown);
      const double start = gap_at(0);
      if (found.answer == CastAnswer::overlapping) {
        EXPECT_LT(start, error);
        continue;
      }
      EXPECT_GT(start, -error) << "overlaps at the start";
      for (int k = 0; k < 16 && found.time > 0; ++k) EXPECT_GT(gap_at(found.time * k / 16), -1e-12);
      if (found.answer == CastAnswer::miss) continue;
      EXPECT_NEAR(gap_at(found.time), 0, error);
      EXPECT_NEAR((found.point - (sphere.centre + found.time * way)).norm(), sphere.radius, 2 * error);
    }
  }
}

TEST(PrimitivePairs, AreTheSameWithWorlds) {
  shapes::Random random(6);
  const std::vector<TrueBody> all = primitives();
  World world;
  std::vector<ShapeId> shapes_of_world;
  for (const TrueBody& body : all) shapes_of_world.push_back(world.add_shape(body.shape));
  std::vector<BodyId> ids;
  std::vector<Motion> motions;
  std::vector<std::size_t> kinds;
  for (int i = 0; i < 60; ++i) {
    kinds.push_back(static_cast<std::size_t>(random(0, 9.999)));
    motions.push_back(random_motion(random, rigid_pose(random, 3), 0.5, 0.5));
    motions.back().end.linear() = Eigen::Quaterniond(motions.back().end.linear()).normalized().toRotationMatrix();
    ids.push_back(world.add_body(shapes_of_world[kinds.back()], motions.back().start));
    world.set_motion(ids.back(), motions.back());
  }
  std::vector<std::pair<int, int>> found, expected;
  const auto number = [&](BodyId id) { return static_cast<int>(std::find(ids.begin(), ids.end(), id) - ids.begin()); };
  world.find_candidates({}, [&](const CandidatePair& pair) {
    found.push_back(std::minmax({number(pair.a), number(pair.b)}));
  });
  std::sort(found.begin(), found.end());
  int touching = 0;
  for (int i = 0; i < 60; ++i) {
    for (int j = i + 1; j < 60; ++j) {
      const auto u = static_cast<std::size_t>(i), v = static_cast<std::size_t>(j);
      const bool apart = separated(*all[kinds[u]].shape, motions[u], *all[kinds[v]].shape, motions[v]).separated;
      if (!apart) expected.emplace_back(i, j);
      for (const Real t : {Real(0), Real(0.5), Real(1)}) {
        if (gap(at(all[kinds[u]], motions[u], t), at(all[kinds[v]], motions[v], t)) > -1e-2) continue;
        EXPECT_FALSE(apart);
        ++touching;
      }
    }
  }
  EXPECT_EQ(found, expected);
  EXPECT_GT(touching, 20);
}

// ---- Moving ------------------------------------------------------------------

TEST(PrimitivePairs, FirstContactsAreNotLate) {
  Pairs pairs(7);
  int contacts = 0, misses = 0;
  pairs.for_each(50, [&](const Placed& p) {
    shapes::Random& random = pairs.random();
    Motion motion_a = random_motion(random, p.motion_a.start, 0.5, 0.3 * p.motion_a.scale),
           motion_b = random_motion(random, p.motion_b.start, 0.5, 1.5 * p.motion_a.scale);
    motion_a.scale = p.motion_a.scale;
    motion_b.scale = p.motion_b.scale;
    for (Motion* m : {&motion_a, &motion_b}) {
      m->end.linear() = Eigen::Quaterniond(m->end.linear()).normalized().toRotationMatrix();
    }
    const auto gap_at = [&](Real t) { return gap(at(p.a, motion_a, t), at(p.b, motion_b, t)); };
    const Real least = least_value([&](Real t) { return gap_at(t); });
    const bool apart = separated(*p.a.shape, motion_a, *p.b.shape, motion_b).separated;
    if (apart) {
      ASSERT_GT(static_cast<double>(least), -p.error - 1e-15 * p.size);
    }
    // A body that holds the other at the start has no first contact.
    if (p.gap <= 0) return;
    const auto contact = first_contact(*p.a.shape, motion_a, *p.b.shape, motion_b);
    if (!contact) {
      ASSERT_GT(static_cast<double>(least), -p.error - 1e-15 * p.size);
      ++misses;
      return;
    }
    ++contacts;
    ASSERT_FALSE(contact->exhausted);
    const double slack = slack_of(p) + 1e-5 * p.motion_a.scale;
    // Nothing touches before, and the bodies do then.
    Real before = infinity;
    for (int i = 0; i <= 40; ++i) before = std::min(before, gap_at(Real(contact->time) * i / 40));
    if (before < 0) {
      ASSERT_GT(static_cast<double>(before), -slack);
    }
    ASSERT_LT(std::abs(static_cast<double>(gap_at(contact->time))), slack);
    ASSERT_NEAR(contact->normal.norm(), 1, 1e-12);
    const Point point = real(contact->point);
    for (const bool first : {true, false}) {
      const TrueBody& body = first ? p.a : p.b;
      if (body.radius == 0) continue;
      const double off = static_cast<double>(signed_to(at(body, first ? motion_a : motion_b, contact->time), point));
      ASSERT_LT(std::abs(off), slack);
    }
  });
  EXPECT_GT(contacts, 10);
  EXPECT_GT(misses, 10);
}

TEST(PrimitivePairs, ContactsSayWhereTheyAreAndWhetherBodiesOverlap) {
  const ShapePtr ball = make_sphere(0.5);
  const Motion falling{shift(0.1, 3, 0.2), shift(0.1, 1, 0.2)};
  const ShapePtr floor = make_box({4, 1, 4});
  const auto hit = first_contact(*ball, falling, *floor, {});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->time, 0.75, 1e-6);
  EXPECT_LT((hit->point - Vector(0.1, 1, 0.2)).norm(), 1e-5);
  EXPECT_LT((hit->normal - Vector::UnitY()).norm(), 1e-5);
  EXPECT_FALSE(hit->overlapping);
  const auto plane = first_contact(*ball, falling, HalfSpace{Vector::UnitY(), 1});
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->time, 0.75, 1e-6);
  EXPECT_LT((plane->point - Vector(0.1, 1, 0.2)).norm(), 1e-5);
  EXPECT_FALSE(plane->overlapping);
  const Motion sunk{shift(0, 1.4, 0), shift(0, 1.2, 0)};
  EXPECT_TRUE(first_contact(*ball, sunk, *floor, {})->overlapping);
  EXPECT_TRUE(first_contact(*ball, sunk, HalfSpace{Vector::UnitY(), 1})->overlapping);
  const Motion beside{shift(0, 0, 0), shift(0.1, 0, 0)};
  EXPECT_TRUE(first_contact(*ball, beside, *ball, Motion::resting(shift(0.9, 0, 0)))->overlapping);
  EXPECT_FALSE(first_contact(*ball, beside, *ball, Motion::resting(shift(1.05, 0, 0)))->overlapping);
  EXPECT_FALSE(first_contact(*ball, beside, *ball, Motion::resting(shift(1.2, 0, 0))));
}

// ---- Contact points ----------------------------------------------------------

TEST(PrimitivePairs, ContactPointsAreThereWhereverBodiesAreNear) {
  Pairs pairs(8);
  int near = 0;
  pairs.for_each(150, [&](const Placed& p) {
    const double unit = p.motion_a.scale, margin = 0.02 * unit;
    const Points points = contacts(*p.a.shape, p.motion_a, *p.b.shape, p.motion_b, {.margin = margin}, 10 * p.size);
    if (p.gap > margin + slack_of(p)) {
      for (const ManifoldPoint& q : points) EXPECT_LE(q.separation, margin * (1 + 1e-9));
    }
    if (!(p.gap < margin - slack_of(p)) || p.gap < -0.02 * unit) return;
    ++near;
    // One body may hold the other wholly, which has no contact points with an open or hollow one.
    if (p.gap > 0) {
      ASSERT_FALSE(points.empty());
    }
    if (!(p.gap > 1e-6 * unit)) return;
    // The nearest point is one of them.
    double least = infinity;
    for (const ManifoldPoint& q : points) least = std::min(least, q.separation);
    ASSERT_NEAR(least, p.gap, slack_of(p) + 1e-9 * unit);
    const Points other = contacts(*p.b.shape, p.motion_b, *p.a.shape, p.motion_a, {.margin = margin}, 10 * p.size);
    ASSERT_FALSE(other.empty());
  });
  EXPECT_GT(near, 25);
}

TEST(PrimitivePairs, ContactPointsOfSimplePairsAreExact) {
  const ShapePtr ball = make_sphere(0.5), other = make_sphere(1), box = make_box({1, 1, 1});
  const auto only = [](const Points& points) {
    EXPECT_EQ(points.size(), 1U);
    return points.empty() ? ManifoldPoint{} : points[0];
  };
  for (const double gap : {0.01, 0.0, -0.1}) {
    const Vector way = Vector(1, 2, 2) / 3;
    const ManifoldPoint balls =
        only(contacts(*ball, Motion::resting(shift(way[0] * (1.5 + gap), way[1] * (1.5 + gap), way[2] * (1.5 + gap))),
                      *other, {}, {.margin = 0.02}));
    EXPECT_NEAR(balls.separation, gap, 1e-12);
    EXPECT_LT((balls.normal - way).norm(), 1e-12);
    EXPECT_LT((balls.point_b - way).norm(), 1e-12);
    EXPECT_LT((balls.point_a - way * (1 + gap)).norm(), 1e-12);
    const ManifoldPoint on_box =
        only(contacts(*ball, Motion::resting(shift(0.1, 1.5 + gap, 0.2)), *box, {}, {.margin = 0.02}));
    EXPECT_NEAR(on_box.separation, gap, 1e-12);
    EXPECT_LT((on_box.point_b - Vector(0.1, 1, 0.2)).norm(), 1e-12);
    const ManifoldPoint on_plane = only(
        contacts(*ball, Motion::resting(shift(0.1, 1.5 + gap, 0.2)), HalfSpace{Vector::UnitY(), 1}, {.margin = 0.02}));
    EXPECT_NEAR(on_plane.separation, gap, 1e-12);
    EXPECT_LT((on_plane.point_a - Vector(0.1, 1 + gap, 0.2)).norm(), 1e-12);
    EXPECT_LT((on_plane.point_b - Vector(0.1, 1, 0.2)).norm(), 1e-12);
  }
  // The centre has entered, deeper than the radius.
  const ManifoldPoint deep = only(contacts(*ball, Motion::resting(shift(0.1, 0.4, 0.2)), *box, {}));
  EXPECT_NEAR(deep.separation, -1.1, 1e-12);
  EXPECT_LT((deep.normal - Vector::UnitY()).norm(), 1e-12);
  const Points lying = contacts(*make_capsule(Vector(-0.5, 0, 0), Vector(0.5, 0, 0), 0.2),
                                Motion::resting(shift(0, 1.19, 0)), *box, {}, {.margin = 0.02});
  EXPECT_GE(lying.size(), 2U);
  for (const ManifoldPoint& p : lying) EXPECT_NEAR(p.separation, -0.01, 1e-7);
}

TEST(PrimitivePairs, QueriesDoNotAllocate) {
  const std::vector<TrueBody> all = primitives();
  const ShapePtr mesh = make_shape(shapes::torus(1, 0.4, 16, 8));
  const auto ask = [&] {
    for (const TrueBody& body : all) {
      const Motion motion{shift(1.2, 0.1, 0), shift(1, 0.1, 0)};
      separated(*body.shape, motion, *mesh, {});
      distance(*body.shape, motion, *mesh, {});
      first_contact(*body.shape, motion, *mesh, {});
    }
  };
  ask();
  const long before = allocations;
  ask();
  EXPECT_EQ(allocations - before, 0);
}

}  // namespace
}  // namespace encage::test
