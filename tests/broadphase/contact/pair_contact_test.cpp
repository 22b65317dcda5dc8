// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/count_allocations.h"
#include "oracles/sampled.h"

#include <encage/contact.h>
#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;

std::vector<Body> bodies() {
  std::vector<Body> all;
  for (const Sample& sample : sample_shapes(0)) all.emplace_back(without_cages(sample));
  for (const char* name : {"star", "torus"}) {
    for (Sample sample : sample_shapes(0)) {
      if (sample.name != name) continue;
      all.emplace_back(without_cages(scaled(sample, -2)));
      sample.hierarchy.origin = Vector(500, -300.5, 0.375);
      all.emplace_back(without_cages(sample));
    }
  }
  return all;
}

/// Two bodies and a step in which they come close to each other and often touch.
struct Scene {
  const Body& a;
  const Body& b;
  Motion motion_a, motion_b;
};

Scene random_scene(shapes::Random& random, const std::vector<Body>& all) {
  const Body &a = all[random.integer(static_cast<int>(all.size()))],
             &b = all[random.integer(static_cast<int>(all.size()))];
  const double size = 0.4 * (a.diagonal() + b.diagonal());
  const double angle = random.integer(4) == 0 ? 2.5 : 0.2, way = random.integer(3) == 0 ? 1.5 * size : 0.2 * size;
  // The motion is about the local origins, so that bodies far from the body frame's origin meet as well.
  const auto about_origin = [&](const Body& body, Motion motion) {
    motion.start.translation() -= motion.start.linear() * body.origin();
    motion.end.translation() -= motion.end.linear() * body.origin();
    return motion;
  };
  Pose pose_a = random_pose(random, 3), pose_b = random_pose(random, 0);
  pose_b.translation() = pose_a.translation() + random_direction(random) * random(0.5, 1.1) * size;
  Scene scene{a, b, about_origin(a, random_motion(random, pose_a, angle, way)),
              about_origin(b, random_motion(random, pose_b, angle, way))};
  if (random.integer(10) == 0) scene.motion_a.end = scene.motion_a.start;
  if (random.integer(10) == 0) scene.motion_b.end = scene.motion_b.start;
  return scene;
}

ContactOptions random_options(shapes::Random& random) {
  ContactOptions options;
  if (random.integer(2) == 0) options.margin = random(0, 0.05);
  if (random.integer(3) == 0) options.arc = random(0, 0.05);
  if (random.integer(4) == 0) options.latest = random(0, 1);
  return options;
}

/// Tests all pairs of triangles, in a random order from `engine`.
std::optional<Contact> brute_force(const Scene& scene, const ContactOptions& options, std::mt19937& engine) {
  const std::int64_t count_b = scene.b.mesh().triangles.rows();
  std::vector<std::int64_t> pairs(static_cast<std::size_t>(scene.a.mesh().triangles.rows() * count_b));
  std::iota(pairs.begin(), pairs.end(), 0);
  std::shuffle(pairs.begin(), pairs.end(), engine);
  PairContact contact(*scene.a.shape, scene.motion_a, *scene.b.shape, scene.motion_b, options);
  for (const std::int64_t p : pairs) {
    contact.test(static_cast<std::int32_t>(p / count_b), static_cast<std::int32_t>(p % count_b));
  }
  return contact.first();
}

std::optional<Contact> ask(const Scene& scene, const ContactOptions& options = {}) {
  return first_contact(*scene.a.shape, scene.motion_a, *scene.b.shape, scene.motion_b, options);
}

void expect_same(const std::optional<Contact>& x, const std::optional<Contact>& y) {
  ASSERT_EQ(x.has_value(), y.has_value());
  if (!x) return;
  EXPECT_EQ(x->time, y->time);
  EXPECT_EQ(x->kind, y->kind);
  EXPECT_EQ(x->vertices, y->vertices);
  // The same features belong to different triangles, so the results are equal up to rounding.
  EXPECT_LT((x->point - y->point).norm(), 1e-9);
  EXPECT_LT((x->normal - y->normal).norm(), 1e-6);
  EXPECT_EQ(x->overlapping, y->overlapping);
}

int rounds(int usual) {
  const char* factor = std::getenv("ENCAGE_CONTACT_ROUNDS");  // longer runs by hand
  return factor ? std::atoi(factor) : usual;
}

TEST(FirstContact, IsThatOfAllPairsOfTrianglesInAnyOrder) {
  shapes::Random random(1);
  std::mt19937 engine(1);
  const std::vector<Body> all = bodies();
  int contacts = 0, kinds[3] = {};
  const int count = rounds(700);
  for (int round = 0; round < count && !HasFailure(); ++round) {
    SCOPED_TRACE(round);
    const Scene scene = random_scene(random, all);
    const ContactOptions options = random_options(random);
    const auto found = ask(scene, options);
    expect_same(found, brute_force(scene, options, engine));
    if (!found) continue;
    ++contacts;
    ++kinds[static_cast<int>(found->kind)];
  }
  EXPECT_GT(contacts, count / 3);
  EXPECT_LT(contacts, count * 9 / 10);
  for (const int kind : kinds) EXPECT_GT(kind, count / 40);
}

TEST(FirstContact, LatestCutsAndChangesNothingElse) {
  shapes::Random random(2);
  const std::vector<Body> all = bodies();
  int cut = 0;
  for (int round = 0; round < 300; ++round) {
    const Scene scene = random_scene(random, all);
    const auto found = ask(scene);
    if (!found) continue;
    for (const double latest : {found->time, 0.5 * (found->time + 1), 1.0, found->time - 0x1p-22, 0.5 * found->time}) {
      if (latest < 0) continue;
      const auto again = ask(scene, {.latest = latest});
      EXPECT_EQ(again.has_value(), latest >= found->time);
      if (again) expect_same(found, again);
      cut += !again;
    }
  }
  EXPECT_GT(cut, 50);
}

/// The sampled distance of the bodies is at most the bound at a contact, and above it before.
TEST(FirstContact, TimeIsALowerBoundAndTheBodiesAreNearThen) {
  shapes::Random random(3);
  const std::vector<Body> all = bodies();
  int contacts = 0, none = 0;
  for (int round = 0; round < rounds(200); ++round) {
    SCOPED_TRACE(round);
    const Scene scene = random_scene(random, all);
    ContactOptions options = random_options(random);
    options.latest = 1;
    const auto found = ask(scene, options);
    const double last = found ? found->time : 1;
    const auto least = [&](Real from, Real to, int samples) {
      Real value = std::numeric_limits<Real>::infinity();
      for (int s = 0; s <= samples; ++s) {
        const Real t = from + (to - from) * s / samples;
        const auto ta = at_time(scene.a.mesh(), scene.a.origin(), scene.motion_a, t);
        const auto tb = at_time(scene.b.mesh(), scene.b.origin(), scene.motion_b, t);
        for (const RealTriangle& x : ta) {
          for (const RealTriangle& y : tb) {
            const Real bulge = static_cast<Real>(options.arc) * 4 * t * (1 - t);
            if (distance_bound(x, y) - bulge < value) value = std::min(value, triangle_distance(x, y) - bulge);
          }
        }
      }
      return value;
    };
    const Real start = least(0, 0, 1);
    if (start == 0) continue;  // they cross at the start already
    if (start <= options.margin) {
      ASSERT_TRUE(found);
      EXPECT_EQ(found->time, 0);
      continue;
    }
    // There is no contact before the reported time.
    EXPECT_GT(least(0, static_cast<Real>(last) * (1 - 1e-9L), 12), options.margin);
    if (!found) {
      ++none;
      continue;
    }
    ++contacts;
    // The distance is met within one cell of the grid of times, in which the bodies move by this much.
    EXPECT_LT(least(last, last, 1), options.margin + 20 * 0x1p-22);
  }
  EXPECT_GT(contacts, 20);
  EXPECT_GT(none, 10);
}

TEST(FirstContact, ShiftedBodiesAreProvenSeparateUntilThen) {
  shapes::Random random(4);
  const std::vector<Body> all = bodies();
  int contacts = 0;
  for (int round = 0; round < 400; ++round) {
    SCOPED_TRACE(round);
    Scene scene = random_scene(random, all);
    if (scene.a.sample.hierarchy.solid == Solid::surface_only) continue;
    if (scene.b.sample.hierarchy.solid == Solid::surface_only) continue;
    // Without rotation a part of a step is a step as well.
    scene.motion_a.end.linear() = scene.motion_a.start.linear();
    scene.motion_b.end.linear() = scene.motion_b.start.linear();
    scene.motion_a.end.translation() = scene.motion_a.start.translation() + random.point(1);
    scene.motion_b.end.translation() = scene.motion_b.start.translation() + random.point(1);
    const auto until = [&](double t) {
      const auto cut = [&](Motion motion) {
        motion.end.translation() = (1 - t) * motion.start.translation() + t * motion.end.translation();
        return motion;
      };
      return separated(*scene.a.shape, cut(scene.motion_a), *scene.b.shape, cut(scene.motion_b)).separated;
    };
    if (!until(0)) continue;
    const auto found = ask(scene);
    EXPECT_EQ(until(1), !found.has_value());
    if (!found) continue;
    ++contacts;
    if (found->time > 1e-6) {
      EXPECT_TRUE(until(found->time - 1e-6));
    }
    EXPECT_FALSE(until(std::min(1.0, found->time + 1e-6)));
  }
  EXPECT_GT(contacts, 40);
}

// ---- Content of a contact -------------------------------------------------

/// Displacement since the start of the material point that is at `world` at time t.
Vector path(const Motion& motion, const Vector& world, double t) {
  const Eigen::Matrix3d linear = (1 - t) * motion.start.linear() + t * motion.end.linear();
  const Vector offset = (1 - t) * motion.start.translation() + t * motion.end.translation();
  const Vector x = linear.inverse() * (world - offset);
  return motion.end * x - motion.start * x;
}

Real distance_to(const Point& p, const std::vector<RealTriangle>& triangles) {
  Real least = std::numeric_limits<Real>::infinity();
  for (const RealTriangle& t : triangles) least = std::min(least, point_triangle_distance(p, t));
  return least;
}

/// True if the given vertices, in increasing order, belong to one triangle of the mesh.
bool is_feature(const TriangleMesh& mesh, std::vector<std::int32_t> vertices) {
  if (!std::is_sorted(vertices.begin(), vertices.end())) return false;
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    if (std::all_of(vertices.begin(), vertices.end(),
                    [&](std::int32_t v) { return (mesh.triangles.row(t).array() == v).any(); })) {
      return true;
    }
  }
  return false;
}

TEST(Contacts, LieBetweenTheBodiesAndPointFromBToA) {
  shapes::Random random(5);
  const std::vector<Body> all = bodies();
  int contacts = 0, approaching = 0, margins = 0;
  for (int round = 0; round < 1200; ++round) {
    SCOPED_TRACE(round);
    const Scene scene = random_scene(random, all);
    const ContactOptions options{.margin = random.integer(2) == 0 ? 0 : random(0.01, 0.05)};
    const auto found = ask(scene, options);
    if (!found) continue;
    ++contacts;
    const auto& v = found->vertices;
    const int of_a = found->kind == ContactKind::vertex_face ? 1 : found->kind == ContactKind::face_vertex ? 3 : 2;
    EXPECT_TRUE(is_feature(scene.a.mesh(), {v.begin(), v.begin() + of_a}));
    EXPECT_TRUE(is_feature(scene.b.mesh(), {v.begin() + of_a, v.end()}));
    EXPECT_GE(found->time, 0);
    EXPECT_LE(found->time, 1);
    EXPECT_EQ(found->time, std::floor(found->time * 0x1p22) * 0x1p-22);
    EXPECT_NEAR(found->normal.norm(), 1, 1e-12);

    const auto ta = at_time(scene.a.mesh(), scene.a.origin(), scene.motion_a, found->time);
    const auto tb = at_time(scene.b.mesh(), scene.b.origin(), scene.motion_b, found->time);
    const Point point = found->point.cast<Real>();
    if (found->time == 0) continue;  // the bodies may overlap by any depth
    EXPECT_LT(distance_to(point, ta), 0.5 * options.margin + 1e-5);
    EXPECT_LT(distance_to(point, tb), 0.5 * options.margin + 1e-5);
    const Vector relative =
        path(scene.motion_a, found->point, found->time) - path(scene.motion_b, found->point, found->time);
    if (options.margin > 0) {
      // The normal points from one side of the gap to the other.
      ++margins;
      const Point step = (0.5 * options.margin * found->normal).cast<Real>();
      EXPECT_LT(distance_to(point + step, ta), 1e-5);
      EXPECT_LT(distance_to(point - step, tb), 1e-5);
    } else if (relative.norm() > 1e-3) {
      ++approaching;
      EXPECT_LT(found->normal.dot(relative), 1e-6 * relative.norm());
    }
  }
  EXPECT_GT(contacts, 200);
  EXPECT_GT(approaching, 50);
  EXPECT_GT(margins, 30);
}

TEST(FirstContact, KnownFallOntoAFace) {
  const std::vector<Body> all = bodies();
  const Body& box = find(all, "box");  // half 1
  const Body& star = find(all, "star");
  // The tip of the star, at -1, falls from 3 to 0 and reaches the face at 1 after a third of the step.
  const Motion fall{shift(0.25, 0.125, 3), shift(0.25, 0.125, 0)}, rest = Motion::resting(Pose::Identity());
  const auto found = first_contact(*star.shape, fall, *box.shape, rest);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->kind, ContactKind::vertex_face);
  EXPECT_NEAR(found->time, 1.0 / 3, 1e-6);
  EXPECT_LE(found->time, 1.0 / 3);
  EXPECT_LT((found->point - Vector(0.25, 0.125, 1)).norm(), 1e-5);
  EXPECT_LT((found->normal - Vector::UnitZ()).norm(), 1e-9);
  const auto swapped = first_contact(*box.shape, rest, *star.shape, fall);
  ASSERT_TRUE(swapped);
  EXPECT_EQ(swapped->kind, ContactKind::face_vertex);
  EXPECT_LT((swapped->normal + Vector::UnitZ()).norm(), 1e-9);
  EXPECT_EQ(swapped->vertices[3], found->vertices[0]);
  // A margin of 0.5 is reached a sixth of the step earlier; the arc counts according to the time.
  const auto early = first_contact(*star.shape, fall, *box.shape, rest, {.margin = 0.5});
  ASSERT_TRUE(early);
  EXPECT_NEAR(early->time, 1.0 / 6, 1e-6);
  EXPECT_LT((early->point - Vector(0.25, 0.125, 1.25)).norm(), 1e-5);
  const auto arc = first_contact(*star.shape, fall, *box.shape, rest, {.arc = 0.25});
  ASSERT_TRUE(arc);
  // 1 - 3 t = 0.25 * 4 t (1 - t): t^2 - 4 t + 1 = 0.
  EXPECT_NEAR(arc->time, 2 - std::sqrt(3.0), 1e-5);
  EXPECT_LE(arc->time, 2 - std::sqrt(3.0));
}

TEST(FirstContact, AtRest) {
  const std::vector<Body> all = bodies();
  const Body& box = find(all, "box");
  const auto at = [&](double x, double margin) {
    return first_contact(*box.shape, Motion::resting(Pose::Identity()), *box.shape, Motion::resting(shift(x, 0.3, 0.2)),
                         {.margin = margin});
  };
  EXPECT_FALSE(at(2.01, 0));
  EXPECT_FALSE(at(2.01, 0.0099));
  for (const auto& contact : {at(2, 0), at(2.01, 0.0101), at(2.01, 0.5)}) {
    ASSERT_TRUE(contact);
    EXPECT_EQ(contact->time, 0);
    EXPECT_NEAR(contact->normal.norm(), 1, 1e-12);
    EXPECT_TRUE(contact->point.allFinite());
  }
  EXPECT_LT((at(2.01, 0.0101)->normal + Vector::UnitX()).norm(), 1e-6);  // from b to a
}

/// The contact of two boxes of half 1 of which a moves and b rests at the origin, and of the swapped pair with its
/// normal reversed.
std::array<std::optional<Contact>, 2> of_boxes(const Pose& start, const Pose& end, const ContactOptions& options = {}) {
  static const std::vector<Body> all = bodies();
  const Shape& box = *find(all, "box").shape;
  const Motion motion{start, end}, rest = Motion::resting(Pose::Identity());
  auto swapped = first_contact(box, rest, box, motion, options);
  if (swapped) swapped->normal *= -1;
  return {first_contact(box, motion, box, rest, options), swapped};
}

TEST(FirstContact, PartsBoxesWhoseSidesAreFlush) {
  shapes::Random random(11);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    const double height = random(2.001, 5), depth = random(0, 1.9), beside = round % 2 == 0 ? 0 : random(-1.5, 1.5);
    for (const auto& contact : of_boxes(shift(beside, 0, height), shift(beside, 0, depth))) {
      ASSERT_TRUE(contact);
      EXPECT_NEAR(contact->time, (height - 2) / (height - depth), 1e-6);
      EXPECT_LT((contact->normal - Vector::UnitZ()).norm(), 1e-9) << contact->normal.transpose();
      EXPECT_FALSE(contact->overlapping);
    }
    // Pushed along the floor that both stand on.
    for (const auto& contact : of_boxes(shift(height, beside, 0), shift(depth, beside, 0))) {
      ASSERT_TRUE(contact);
      EXPECT_LT((contact->normal - Vector::UnitX()).norm(), 1e-9) << contact->normal.transpose();
    }
    // Sliding down askew: where sides are flush at first, they are not at the contact.
    for (const auto& contact : of_boxes(shift(beside, 0, height), shift(beside + 0.7, 0.4, depth))) {
      ASSERT_TRUE(contact);
      EXPECT_LT((contact->normal - Vector::UnitZ()).norm(), 1e-9) << contact->normal.transpose();
    }
  }
}

TEST(FirstContact, PartsBodiesThatRestWithinTheMargin) {
  shapes::Random random(12);
  const double margin = 0.01;
  for (const double share : {0.9, 0.6, 0.49, 0.2, 0.01, 0.0}) {
    SCOPED_TRACE(share);
    const double gap = 2 + share * margin;
    for (int round = 0; round < 50; ++round) {
      const double down = round % 5 == 0 ? 0 : 1e-3 * random(0, 1), beside = random(-0.5, 0.5);
      Pose turned = shift(random(-0.4, 0.4), random(-0.4, 0.4), gap);
      turned.linear() = Eigen::AngleAxisd(random(-3, 3), Vector::UnitZ()).toRotationMatrix();
      Pose lower = turned;
      lower.translation() += Vector(random(-1e-3, 1e-3), random(-1e-3, 1e-3), -down);
      for (const auto& contact : of_boxes(turned, lower, {.margin = margin})) {
        ASSERT_TRUE(contact);
        EXPECT_GT(contact->normal.z(), 0.99) << contact->normal.transpose();
      }
      for (const auto& contact : of_boxes(shift(0, 0, gap), shift(0, 0, gap - down), {.margin = margin})) {
        ASSERT_TRUE(contact);
        EXPECT_GT(contact->normal.z(), 0.99) << contact->normal.transpose();
      }
      for (const auto& contact : of_boxes(shift(gap, beside, 0), shift(gap - down, beside, 0), {.margin = margin})) {
        ASSERT_TRUE(contact);
        EXPECT_GT(contact->normal.x(), 0.99) << contact->normal.transpose();
      }
    }
  }
}

TEST(FirstContact, SaysThatBodiesOverlap) {
  shapes::Random random(13);
  const std::vector<Body> all = bodies();
  int overlapping = 0, apart = 0;
  for (int round = 0; round < 400; ++round) {
    SCOPED_TRACE(round);
    const Scene scene = random_scene(random, all);
    const auto ta = at_time(scene.a.mesh(), scene.a.origin(), scene.motion_a, 0);
    const auto tb = at_time(scene.b.mesh(), scene.b.origin(), scene.motion_b, 0);
    bool crossing = false;
    for (const RealTriangle& x : ta) {
      for (const RealTriangle& y : tb) {
        for (int k = 0; k < 3 && !crossing; ++k) {
          crossing = pierces(x[k], x[(k + 1) % 3], y) || pierces(y[k], y[(k + 1) % 3], x);
        }
      }
    }
    const auto found = ask(scene);
    if (crossing) {
      ASSERT_TRUE(found);
      EXPECT_TRUE(found->overlapping);
      EXPECT_EQ(found->time, 0);
    } else {
      EXPECT_FALSE(found && found->overlapping);
    }
    ++(crossing ? overlapping : apart);
  }
  EXPECT_GT(overlapping, 50);
  EXPECT_GT(apart, 50);
}

TEST(FirstContact, BodiesInTheSamePlaceTouchAtOnce) {
  std::mt19937 engine(3);
  shapes::Random random(8);
  for (const Body& body : bodies()) {
    const Pose pose = random_pose(random, 2);
    for (const Motion& motion : {Motion::resting(pose), random_motion(random, pose, 0.3, 0.3)}) {
      const Scene scene{body, body, motion, motion};
      const auto found = ask(scene);
      ASSERT_TRUE(found) << body.sample.name;
      EXPECT_EQ(found->time, 0);
      EXPECT_NEAR(found->normal.norm(), 1, 1e-12);
      EXPECT_TRUE(found->point.allFinite());
      expect_same(found, brute_force(scene, {}, engine));
    }
  }
}

TEST(PairContact, CountsTestsAndSaysHowLate) {
  const std::vector<Body> all = bodies();
  const Body& box = find(all, "box");
  const Motion away = Motion::resting(shift(9, 0, 0)), rest = Motion::resting(Pose::Identity());
  PairContact far(*box.shape, rest, *box.shape, away, {.latest = 0.75});
  EXPECT_EQ(far.latest(), 0.75);
  // Each of 8 vertices is tested once against 12 faces, both ways, and each of 18 edges once against 18.
  for (std::int32_t i = 0; i < 12; ++i) {
    for (std::int32_t j = 0; j < 12; ++j) far.test(i, j);
  }
  EXPECT_EQ(far.feature_tests(), 2 * 8 * 12 + 18 * 18);
  EXPECT_FALSE(far.first());
  EXPECT_EQ(far.latest(), 0.75);
  const Scene scene{box, box, rest, Motion{shift(9, 0, 0), shift(0, 0, 0)}};
  std::mt19937 engine(1);
  const auto found = brute_force(scene, {}, engine);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->time, 7.0 / 9, 1e-6);
}

TEST(FirstContact, RefusesMotionsThatAreNotUsable) {
  const std::vector<Body> all = bodies();
  const Body& box = find(all, "box");
  const Shape& shape = *box.shape;
  const Motion rest = Motion::resting(Pose::Identity());
  struct Case {
    Motion motion;
    std::string reason;
  };
  std::vector<Case> cases;
  for (const double scale : {0.0, -2.0}) {
    cases.push_back({Motion::resting(shift(0), scale),
                     std::string("the scale ") + (scale == 0 ? "0" : "-2") + " is not between 1e-50 and 1e50"});
  }
  Motion mirrored = rest, drifted = rest, turned = rest;
  mirrored.end.linear()(0, 0) = -1;
  drifted.start.linear()(0, 1) = 1e-6;
  turned.end.linear() = Eigen::Vector3d(-1, 1, -1).asDiagonal();
  cases.push_back({mirrored, "the end pose mirrors the body"});
  cases.push_back({drifted,
                   "the start pose is 1.41e-06 from rigid, farther than 1e-9: correct it by nearest_rigid() or "
                   "pose_from()"});
  cases.push_back({turned, "the rotation within the step reaches 180 degrees: split it, e.g. by split_motion()"});
  const auto message = [](const std::function<void()>& call) -> std::string {
    try {
      call();
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  for (const auto& bad : cases) {
    const Motion& motion = bad.motion;
    const std::string& reason = bad.reason;
    EXPECT_EQ(message([&] { first_contact(shape, motion, shape, rest); }), "first contact: body a: " + reason);
    EXPECT_EQ(message([&] { first_contact(shape, rest, shape, motion); }), "first contact: body b: " + reason);
    EXPECT_EQ(message([&] { PairContact(shape, rest, shape, motion); }), "first contact: body b: " + reason);
    EXPECT_EQ(message([&] { first_contact(shape, motion, HalfSpace{}); }), "first contact: body a: " + reason);
  }
}

TEST(FirstContact, DoesNotAllocate) {
  shapes::Random random(9);
  const std::vector<Body> all = bodies();
  std::vector<Scene> scenes;
  for (int i = 0; i < 100; ++i) scenes.push_back(random_scene(random, all));
  int contacts = 0;
  const long before = allocations;
  for (const Scene& scene : scenes) {
    contacts += ask(scene).has_value();
    contacts += first_contact(*scene.a.shape, scene.motion_a, HalfSpace{}).has_value();
    contacts += separated(*scene.a.shape, scene.motion_a, *scene.b.shape, scene.motion_b).separated;
    contacts += !for_each_triangle_pair(*scene.a.shape, scene.motion_a, *scene.b.shape, scene.motion_b, 0.1,
                                        [](TrianglePair) { return false; });
  }
  EXPECT_EQ(allocations, before);
  EXPECT_GT(contacts, 100);
}

}  // namespace
}  // namespace encage::test
