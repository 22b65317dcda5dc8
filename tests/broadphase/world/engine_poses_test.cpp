// SPDX-License-Identifier: GPL-3.0-or-later
// Worlds whose bodies have poses in float, really turn, are sensors, or carry the caller's data.
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/broadphase/world/twin.h"

#include <encage/split_motion.h>

#include <cmath>
#include <vector>

namespace encage::test {
namespace {

Pose float_pose(shapes::Random& random, const Vector& at) {
  Pose pose = shift(at.x(), at.y(), at.z());
  pose.linear() = Eigen::Quaterniond(random_rotation(random, 3.1)).cast<float>().toRotationMatrix().cast<double>();
  return pose;
}

// ---- Poses in float ------------------------------------------------------------

// A tiny cube is placed around the exact image of a corner of a long beam: they overlap.
TEST(WorldPoses, InFloatAreCorrectedAndMissNothing) {
  shapes::Random random(1);
  const TriangleMesh beam = shapes::box(Vector(-100, -1, -1), Vector(100, 1, 1));
  const ShapePtr beam_shape = make_shape(beam);
  int corrected = 0;
  for (int i = 0; i < 400; ++i) {
    World world({.pose_tolerance = 1e-4});
    const double scale = i % 3 == 0 ? random(0.2, 4) : 1;
    const Pose given = float_pose(random, Vector::Zero());
    const BodyId long_one = world.add_body(world.add_shape(beam_shape), given, {.scale = scale});
    const Vector corner = given * (scale * beam.vertex(random.integer(8)));
    const ShapeId cube = world.add_shape(make_shape(shapes::cube(std::pow(10.0, random(-9, -5)))));
    world.add_body(cube, shift(corner.x(), corner.y(), corner.z()));
    ASSERT_EQ(candidates(world).size(), 1U);
    ASSERT_TRUE(is_usable(world.motion(long_one)));
    corrected += world.pose_deviation(long_one) > 0 ? 1 : 0;
    ASSERT_LT(world.pose_deviation(long_one), 1e-6);
    ASSERT_EQ(world.body_counts().corrected, world.pose_deviation(long_one) > 0 ? 1 : 0);
    // What is a little farther away than the correction is rejected still.
    const Vector out = given.linear() * Vector(0, random.integer(2) == 0 ? -1 : 1, 0);
    const Vector beyond = given * Vector::Zero() + out * (scale + 1e-3 * scale);
    world.set_pose(BodyId{1}, shift(beyond.x(), beyond.y(), beyond.z()));
    ASSERT_EQ(candidates(world).size(), 0U);
  }
  EXPECT_EQ(corrected, 400);
}

TEST(WorldPoses, AreRefusedBeyondTheTolerance) {
  World strict, world({.pose_tolerance = 1e-4});
  Pose off = shift(1), far_off = shift(1), mirrored = shift(1), flat = shift(1), nan = shift(1);
  off.linear()(1, 1) = 1 + 5e-5;
  far_off.linear()(1, 1) = 1 + 2e-4;
  mirrored.linear()(0, 0) = -1;
  flat.linear()(2, 2) = 0;
  nan.linear()(2, 2) = std::nan("");
  for (World* w : {&strict, &world}) w->add_shape(sample_shape("box"));
  const auto says = [](World& w, const Pose& pose) { return error_of([&] { w.add_body(ShapeId{0}, pose); }); };
  EXPECT_EQ(says(strict, off),
            "body 0: the pose is 0.0001 from rigid, farther than 1e-9: correct it by nearest_rigid() or pose_from()");
  EXPECT_EQ(says(world, off), "no error");
  EXPECT_EQ(says(world, far_off),
            "body 1: the pose deviates by 0.0002 from a rigid one, more than the tolerance 0.0001");
  EXPECT_EQ(says(world, mirrored), "body 1: the pose mirrors the body");
  EXPECT_EQ(says(world, nan), "body 1: the pose is not finite");
  EXPECT_EQ(says(world, flat),
            "body 1: the pose is 1 from rigid, farther than 1e-9: correct it by nearest_rigid() or pose_from()");
  const BodyId body{0};
  const Motion before = world.motion(body);
  EXPECT_NEAR(world.pose_deviation(body), 5e-5, 1e-15);
  EXPECT_EQ(error_of([&] { world.set_motion(body, {off, mirrored}); }), "body 0: the end pose mirrors the body");
  Pose turned = off;
  turned.linear() = Eigen::AngleAxisd(std::acos(-1.0), Vector::UnitX()).toRotationMatrix() * off.linear();
  EXPECT_EQ(error_of([&] {
              world.set_motion(body, {off, turned});
            }),
            "body 0: the rotation within the step reaches 180 degrees: split it, e.g. by split_motion()");
  EXPECT_EQ(world.motion(body).end.matrix(), before.end.matrix());
  // A rigid pose needs no correction, and the margin goes.
  world.set_pose(body, shift(1));
  EXPECT_EQ(world.pose_deviation(body), 0);
}

TEST(WorldPoses, ThatAreGivenAgainCostNothing) {
  shapes::Random random(3);
  World world({.pose_tolerance = 1e-4});
  const ShapeId box = world.add_shape(sample_shape("box"));
  const Pose a = float_pose(random, Vector::Zero()), b = float_pose(random, Vector(1.5, 0, 0));
  world.add_body(box, a);
  const BodyId second = world.add_body(box, b);
  CandidateStatistics counts;
  ASSERT_EQ(candidates(world, {}, &counts).size(), 1U);
  EXPECT_EQ(counts.asked, 1);
  world.set_pose(second, b);
  world.set_motion(second, {b, b});
  ASSERT_EQ(candidates(world, {}, &counts).size(), 1U);
  EXPECT_EQ(counts.asked, 0);
}

TEST(WorldPoses, AreRestoredWithTheirDeviation) {
  shapes::Random random(4);
  World world({.arcs = true, .pose_tolerance = 1e-4});
  const ShapeId box = world.add_shape(sample_shape("box"));
  const BodyId body = world.add_body(box, float_pose(random, Vector::Zero()), {.pivot = Vector(1, 0, 0)});
  world.set_user_data(body, 77);
  World other;
  other.restore(world.snapshot());
  EXPECT_TRUE(other.options().arcs);
  EXPECT_EQ(other.options().pose_tolerance, 1e-4);
  EXPECT_EQ(other.pose_deviation(body), world.pose_deviation(body));
  EXPECT_GT(other.pose_deviation(body), 0);
  EXPECT_EQ(other.user_data(body), 77U);
}

TEST(WorldPoses, CountInTheMarginsOfPairs) {
  shapes::Random random(5);
  World world({.arcs = true, .pose_tolerance = 1e-4});
  const ShapePtr box = sample_shape("box");
  const ShapeId shape = world.add_shape(box, 0.25);
  const BodyId body = world.add_body(shape, shift(0), {.margin = 0.5, .scale = 3, .pivot = Vector(2, 0, 0)});
  EXPECT_EQ(world.pair_margin(body), 0.75);
  world.set_deformation(body, 0.125);
  EXPECT_EQ(world.pair_margin(body), 0.875);
  world.set_pose(body, float_pose(random, Vector::Zero()));
  const double correction = correction_margin(*box, world.pose_deviation(body), 3);
  EXPECT_GT(correction, 0);
  EXPECT_NEAR(world.pair_margin(body), 0.875 + correction, 1e-15);
  world.set_motion(body, {shift(0), float_pose(random, Vector::Zero())});
  const double arc = arc_margin(*box, world.motion(body), Vector(2, 0, 0));
  EXPECT_GT(arc, 0.1);
  EXPECT_NEAR(world.pair_margin(body), 0.875 + correction_margin(*box, world.pose_deviation(body), 3) + arc, 1e-12);
}

// ---- Arcs ----------------------------------------------------------------------

/// Least distance of the post's axis from the rod as it really turns about its pivot, at sampled times.
Real least_distance(const VelocityMotion& course, const Vector& tip, const Vector& post) {
  const auto at = [&](Real t) {
    const Real angle = t * Real(course.angular_velocity.z());
    const Eigen::AngleAxis<Real> turn(angle, Point::UnitZ());
    const Point pivot = course.pivot.cast<Real>();
    const Point a = pivot + turn * (tip.cast<Real>() - pivot), b = pivot + turn * (-tip.cast<Real>() - pivot);
    return point_segment_distance(post.cast<Real>(), a, b);
  };
  return least_value(at);
}

TEST(WorldArcs, ARodSweepsWhatItsEndsDoNotShow) {
  shapes::Random random(13);
  const ShapePtr rod = make_shape(shapes::box(Vector(-5, -0.01, -0.01), Vector(5, 0.01, 0.01)));
  const ShapePtr post = make_shape(shapes::box(Vector(-0.01, -0.01, -1), Vector(0.01, 0.01, 1)));
  int hits = 0, plain_hits = 0, rejects = 0, far = 0;
  for (int i = 0; i < 1500; ++i) {
    VelocityMotion course;
    const double turn = random(5, 90) * std::acos(-1.0) / 180;
    course.angular_velocity = Vector(0, 0, turn);
    if (i % 2 == 0) course.pivot = Vector(random(-5, 5), 0, 0);
    const Motion motion = split_motion(course, 1.6).front();
    Vector at(random(-10, 10), random(-10, 10), 0);
    if (i % 3 != 0) {  // on the arc of a point of the rod
      const double part = random(0.1, 0.9), x = random(-5, 5);
      at = course.pivot + Eigen::AngleAxisd(part * turn, Vector::UnitZ()) * (Vector(x, 0, 0) - course.pivot);
    }
    const Real distance = least_distance(course, Vector(5, 0, 0), at);
    const bool touches = distance <= 0.01L;  // the post's faces are at least as far from its axis
    const auto found = [&](bool arcs) {
      World world({.arcs = arcs});
      const BodyId moving = world.add_body(world.add_shape(rod), Pose::Identity(), {.pivot = course.pivot});
      world.add_body(world.add_shape(post), shift(at.x(), at.y()), {.kind = BodyKind::static_});
      world.set_motion(moving, motion);
      return !candidates(world).empty();
    };
    const bool with_arcs = found(true);
    if (touches) {
      ++hits;
      plain_hits += found(false) ? 1 : 0;
      ASSERT_TRUE(with_arcs) << i;
    }
    const Real slack = Real(arc_margin(*rod, motion, course.pivot)) + 0.1L;
    if (distance > 2 * slack) {
      ++far;
      rejects += with_arcs ? 0 : 1;
    }
  }
  EXPECT_GT(hits, 200);
  EXPECT_LT(plain_hits, hits - 20);  // what is missed without
  EXPECT_EQ(rejects, far);
  EXPECT_GT(far, 200);
}

TEST(WorldArcs, ReachHalfSpaces) {
  const ShapePtr rod = make_shape(shapes::box(Vector(0, -0.01, -0.01), Vector(5, 0.01, 0.01)));
  const HalfSpace wall = {-Vector::UnitX(), -4.9};
  for (const bool arcs : {false, true}) {
    World world({.arcs = arcs});
    Motion motion;
    motion.start.linear() = Eigen::AngleAxisd(-0.75, Vector::UnitZ()).toRotationMatrix();
    motion.end.linear() = Eigen::AngleAxisd(0.75, Vector::UnitZ()).toRotationMatrix();
    const BodyId body = world.add_body(world.add_shape(rod), motion.start);
    world.add_half_space(wall);
    EXPECT_TRUE(candidates(world).empty());
    world.set_motion(body, motion);
    EXPECT_EQ(candidates(world).size(), arcs ? 1U : 0U);
    world.set_options(body, {.pivot = Vector(100, 0, 0)});
    EXPECT_EQ(candidates(world).size(), arcs ? 1U : 0U);
    world.set_pose(body, motion.end);
    EXPECT_TRUE(candidates(world).empty());
  }
}

// ---- Sensors ---------------------------------------------------------------------

TEST(WorldSensors, FormPairsWithEveryKind) {
  const BodyKind kinds[] = {BodyKind::dynamic, BodyKind::kinematic, BodyKind::static_};
  for (const BodyKind a : kinds) {
    for (const BodyKind b : kinds) {
      for (const int sensors : {0, 1, 2, 3}) {
        World world;
        const ShapeId box = world.add_shape(sample_shape("box"));
        world.add_body(box, shift(0), {.kind = a, .sensor = (sensors & 1) != 0});
        world.add_body(box, shift(0.5), {.kind = b, .sensor = (sensors & 2) != 0});
        const bool dynamic = a == BodyKind::dynamic || b == BodyKind::dynamic;
        const bool both_static = a == BodyKind::static_ && b == BodyKind::static_;
        const bool expected = dynamic || (sensors != 0 && !both_static);
        EXPECT_EQ(candidates(world).size(), expected ? 1U : 0U);
      }
    }
  }
}

TEST(WorldSensors, MeetHalfSpacesUnlessTheyAreStatic) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));  // half edge 1
  world.add_half_space({Vector::UnitZ(), 0});
  const BodyId lift = world.add_body(box, shift(0, 0, 0.5), {.kind = BodyKind::kinematic});
  world.add_body(box, shift(10, 0, 0.5), {.kind = BodyKind::static_, .sensor = true});
  EXPECT_TRUE(events(world).empty());
  BodyOptions options = world.options(lift);
  options.sensor = true;
  world.set_options(lift, options);
  EXPECT_EQ(events(world).size(), 1U);
  EXPECT_EQ(events(world).front().what, Found::What::persists);
  world.set_pose(lift, shift(0, 0, 1.5));
  EXPECT_EQ(events(world).front().what, Found::What::ends);
  world.set_pose(lift, shift(0, 0, 0.5));
  EXPECT_EQ(events(world).size(), 1U);
  options.sensor = false;
  world.set_options(lift, options);
  const std::vector<Found> after = events(world);
  ASSERT_EQ(after.size(), 1U);
  EXPECT_EQ(after.front().what, Found::What::ends);
}

// ---- Lists and data ----------------------------------------------------------------

TEST(WorldLists, NameWhatIsThere) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box")), star = world.add_shape(sample_shape("star"));
  std::vector<BodyId> all;
  const BodyKind kinds[] = {BodyKind::dynamic, BodyKind::kinematic, BodyKind::static_, BodyKind::dynamic};
  for (int i = 0; i < 4; ++i) {
    all.push_back(world.add_body(box, shift(10 * i), {.kind = kinds[i], .sensor = i == 1}));
    EXPECT_EQ(world.user_data(all.back()), 0U);
    world.set_user_data(all.back(), ~std::uint64_t{0} - static_cast<std::uint64_t>(i));
  }
  EXPECT_EQ(world.bodies(), all);
  EXPECT_EQ(world.shapes(), (std::vector{box, star}));
  EXPECT_TRUE(world.half_spaces().empty());
  const HalfSpaceId floor = world.add_half_space({});
  EXPECT_EQ(world.half_spaces(), std::vector{floor});
  world.set_awake(all[3], false);
  const BodyCounts counts = world.body_counts();
  EXPECT_EQ(counts.dynamic, 2);
  EXPECT_EQ(counts.kinematic, 1);
  EXPECT_EQ(counts.static_, 1);
  EXPECT_EQ(counts.awake, 2);
  EXPECT_EQ(counts.sensors, 1);
  EXPECT_EQ(counts.corrected, 0);
  EXPECT_EQ(world.user_data(all[2]), ~std::uint64_t{0} - 2);
  world.remove_body(all[1]);
  world.remove_shape(star);
  EXPECT_EQ(world.bodies(), (std::vector{all[0], all[2], all[3]}));
  EXPECT_EQ(world.shapes(), std::vector{box});
  EXPECT_EQ(world.body_counts().kinematic, 0);
  // A new body has no data of the one before.
  const BodyId again = world.add_body(box, shift(50));
  EXPECT_EQ(index(again), index(all[1]));
  EXPECT_EQ(world.user_data(again), 0U);
  EXPECT_EQ(world.bodies()[1], again);
}

TEST(WorldLists, DataDoNotDisturbPairs) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  const BodyId a = world.add_body(box, shift(0));
  world.add_body(box, shift(0.5));
  ASSERT_EQ(candidates(world).size(), 1U);
  world.set_user_data(a, 5);
  CandidateStatistics counts;
  world.find_candidates({}, [&](const CandidatePair& pair) {
    EXPECT_EQ(world.user_data(pair.a), 5U);
    EXPECT_EQ(error_of([&] { world.set_user_data(pair.a, 6); }),
              "the world cannot be changed while it visits candidates");
  });
  candidates(world, {}, &counts);
  EXPECT_EQ(counts.asked, 0);
}

}  // namespace
}  // namespace encage::test
