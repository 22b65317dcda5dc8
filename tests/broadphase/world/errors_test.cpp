// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "tests/broadphase/world/twin.h"

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <new>

namespace encage::test {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(WorldErrors, RefuseBadInputAndStayAsTheyAre) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));
  const BodyId body = world.add_body(shape, shift(0));
  const BodyId ground = world.add_body(shape, shift(1), {.kind = BodyKind::static_});
  const BodyId removed = world.add_body(shape, shift(1, 1));
  world.remove_body(removed);
  world.add_half_space({Vector::UnitZ(), 0});
  const Motion before = {shift(0), shift(0.25)};
  world.set_motion(body, before);
  const std::vector<Found> expected = candidates(world);
  ASSERT_EQ(expected.size(), 2u);

  Pose nan = shift(0), infinite = shift(infinity), stretched = shift(0), distant = shift(1e160), turned = shift(0);
  nan.linear()(1, 2) = std::nan("");
  stretched.linear()(1, 1) = 1 + 1e-8;
  Eigen::Isometry3d mirrored = Eigen::Isometry3d::Identity();
  mirrored.linear()(2, 2) = -1;
  turned.linear() = Eigen::AngleAxisd(std::acos(-1.0), Vector(1, 2, 3).normalized()).toRotationMatrix();
  const auto no_visit = [](const CandidatePair&) { FAIL(); };
  const std::string remedy = ": correct it by nearest_rigid() or pose_from()";
  struct Case {
    std::function<void()> call;
    std::string says;
  };
  const std::vector<Case> cases = {
      {[&] { world.add_shape(nullptr); }, "shape 1: null"},
      {[&] { world.add_body(ShapeId{7}, shift(0)); }, "body 2 (generation 1): shape 7 does not exist"},
      {[&] { world.add_body(shape, nan); }, "body 2 (generation 1): the pose is not finite"},
      {[&] { world.add_body(shape, infinite); }, "body 2 (generation 1): the pose is not finite"},
      {[&] { world.add_body(shape, distant); }, "body 2 (generation 1): the pose is farther than 1e150 away"},
      {[&] { world.add_body(shape, stretched); },
       "body 2 (generation 1): the pose is 2e-08 from rigid, farther than 1e-9" + remedy},
      {[&] { world.add_body(shape, shift(0), {.margin = -1}); }, "body 2 (generation 1): the margin -1 is negative"},
      {[&] { world.add_body(shape, shift(0), {.margin = std::nan("")}); },
       "body 2 (generation 1): the margin nan is not a number"},
      {[&] { world.add_body(shape, shift(0), {.margin = infinity}); },
       "body 2 (generation 1): the margin inf is larger than 1e150"},
      {[&] { world.set_pose(body, nan); }, "body 0: the pose is not finite"},
      {[&] { world.set_pose(body, stretched); }, "body 0: the pose is 2e-08 from rigid, farther than 1e-9" + remedy},
      {[&] { world.add_body(shape, mirrored); }, "body 2 (generation 1): the pose mirrors the body"},
      {[&] {
         world.set_motion(body, {shift(0), mirrored});
       },
       "body 0: the end pose mirrors the body"},
      {[&] {
         world.set_motion(body, {shift(0), nan});
       },
       "body 0: the end pose is not finite"},
      {[&] {
         world.set_motion(body, {infinite, shift(0)});
       },
       "body 0: the start pose is not finite"},
      {[&] {
         world.set_motion(body, {shift(0), distant});
       },
       "body 0: the end pose is farther than 1e150 away"},
      {[&] {
         world.set_motion(body, {stretched, shift(0)});
       },
       "body 0: the start pose is 2e-08 from rigid, farther than 1e-9" + remedy},
      {[&] {
         world.set_motion(body, {shift(0), turned});
       },
       "body 0: the rotation within the step reaches 180 degrees: split it, e.g. by split_motion()"},
      {[&] {
         world.set_motion(ground, {shift(0), shift(1)});
       },
       "body 1: a static body cannot move within a step"},
      {[&] { world.set_pose(removed, shift(0)); }, "body 2: was removed"},
      {[&] { world.set_motion(BodyId{9}, before); }, "body 9: does not exist"},
      {[&] { world.set_motion(BodyId::none, before); }, "body none: does not exist"},
      {[&] { world.remove_body(removed); }, "body 2: was removed"},
      {[&] { world.remove_body(BodyId{9}); }, "body 9: does not exist"},
      {[&] { (void)world.motion(removed); }, "body 2: was removed"},
      {[&] { (void)world.options(BodyId{3}); }, "body 3: does not exist"},
      {[&] { (void)world.shape(BodyId{3}); }, "body 3: does not exist"},
      {[&] { (void)world.half_space(HalfSpaceId{1}); }, "half-space 1: does not exist"},
      {[&] {
         world.add_half_space({Vector::Ones(), 0});
       },
       "half-space 1: the normal's length is 1.73205080757, not 1"},
      {[&] {
         world.add_half_space({Vector::UnitX() * (1 + 2e-9), 0});
       },
       "half-space 1: the normal's length is 1.000000002, not 1"},
      {[&] {
         world.add_half_space({Vector(0, 0, infinity), 0});
       },
       "half-space 1: the normal is not finite"},
      {[&] {
         world.add_half_space({Vector::UnitX(), std::nan("")});
       },
       "half-space 1: the offset nan is not finite or beyond 1e150"},
      {[&] { world.find_candidates({.pair = {.margin = -0.5}}, no_visit); },
       "candidate options: the margin -0.5 is negative"},
      {[&] { world.find_candidates({.pair = {.margin = std::nan("")}}, no_visit); },
       "candidate options: the margin nan is not a number"},
      {[&] { world.find_candidates({.pair = {.margin = infinity}}, no_visit); },
       "candidate options: the margin inf is larger than 1e150"},
      {[&] { world.add_shape(sample_shape("box"), -0.5); }, "shape 1: the margin -0.5 is negative"},
      {[&] { world.remove_shape(ShapeId{5}); }, "shape 5: does not exist"},
      {[&] { world.remove_shape(shape); }, "shape 0: body 0 has it"},
      {[&] { world.remove_half_space(HalfSpaceId{4}); }, "half-space 4: does not exist"},
      {[&] { world.remove_half_space(HalfSpaceId::none); }, "half-space none: does not exist"},
      {[&] { world.set_shape(body, ShapeId{1}); }, "body 0: shape 1 does not exist"},
      {[&] { world.set_shape(removed, shape); }, "body 2: was removed"},
      {[&] { world.set_filter(removed, {}); }, "body 2: was removed"},
      {[&] { world.set_options(body, {.margin = -2}); }, "body 0: the margin -2 is negative"},
      {[&] { world.set_options(body, {.kind = BodyKind::static_}); },
       "body 0: a body that moves within a step cannot become static"},
      {[&] { world.add_body(shape, shift(0), {.scale = 0}); },
       "body 2 (generation 1): the scale 0 is not between 1e-50 and 1e50"},
      {[&] { world.set_options(body, {.pivot = Vector(0, infinity, 0)}); },
       "body 0: the pivot is not finite or beyond 1e150"},
      {[&] { world.set_options(body, {.pivot = Vector(0, 0, std::nan(""))}); },
       "body 0: the pivot is not finite or beyond 1e150"},
      {[&] { world.set_user_data(removed, 1); }, "body 2: was removed"},
      {[&] { (void)world.user_data(removed); }, "body 2: was removed"},
      {[&] { (void)world.pose_deviation(removed); }, "body 2: was removed"},
      {[&] { World(WorldOptions{.pose_tolerance = -1}); },
       "world options: the pose tolerance -1 is not between 0 and 0.1"},
      {[&] { World(WorldOptions{.pose_tolerance = std::nan("")}); },
       "world options: the pose tolerance nan is not between 0 and 0.1"},
      {[&] { world.set_scale(body, -2); }, "body 0: the scale -2 is not between 1e-50 and 1e50"},
      {[&] { world.set_scale(body, std::nan("")); }, "body 0: the scale nan is not between 1e-50 and 1e50"},
      {[&] { world.set_scale(body, infinity); }, "body 0: the scale inf is not between 1e-50 and 1e50"},
      {[&] {
         world.set_motion(body, {shift(0), shift(1), 3});
       },
       "body 0: the motion's scale 3 is not the body's, 1"},
      {[&] { world.set_awake(removed, true); }, "body 2: was removed"},
      {[&] { world.set_deformation(body, -1e-3); }, "body 0: the deformation -0.001 is negative"},
      {[&] { world.set_deformation(body, 1e200); }, "body 0: the deformation 1e+200 is larger than 1e150"},
      {[&] { world.set_deformation(removed, 1); }, "body 2: was removed"},
      {[&] { (void)world.margin(ShapeId{1}); }, "shape 1: does not exist"},
      {[&] { (void)world.is_awake(BodyId{4}); }, "body 4: does not exist"},
  };
  for (const Case& c : cases) {
    EXPECT_EQ(error_of(c.call), c.says);
    EXPECT_EQ(world.body_count(), 2);
    EXPECT_EQ(world.shape_count(), 1);
    EXPECT_EQ(world.half_space_count(), 1);
    EXPECT_EQ(world.motion(body).end.matrix(), before.end.matrix());
    EXPECT_EQ(candidates(world), expected) << c.says;
  }
  const auto next = static_cast<BodyId>(index(removed) | std::uint64_t{1} << 32);
  EXPECT_EQ(world.add_body(shape, shift(0)), next);
}

/// Makes the call run out of memory at its first allocation, at its second, and so on, until it succeeds. Returns the
/// number of failures.
int run_out_of_memory(const std::function<void()>& call, const std::function<void()>& check) {
  for (int failures = 0;; ++failures) {
    allocations_left = failures;
    try {
      call();
      allocations_left = -1;
      return failures;
    } catch (const std::bad_alloc&) {
      allocations_left = -1;
      check();
    }
  }
}

TEST(WorldErrors, RunOutOfMemoryAndStayAsTheyAre) {
  const ShapePtr box = sample_shape("box");
  World world, undisturbed;
  const auto both = [&](auto&& change) { change(undisturbed), change(world); };
  both([&](World& w) {
    const ShapeId shape = w.add_shape(box);
    for (int i = 0; i < 3; ++i) w.add_body(shape, shift(0.3 * i));
    candidates(w);
    w.remove_body(BodyId{1});
    w.set_awake(BodyId{2}, false);
  });
  std::vector<Found> seen;
  const auto keep = [&](const CandidatePair& pair) { seen.push_back(found(pair)); };
  seen.reserve(1000);
  int failures = 0;
  for (int step = 0; step < 12; ++step) {
    const auto counts = [&](const World& w) {
      return std::array{w.shape_count(), w.body_count(), w.half_space_count()};
    };
    const auto check = [&] { EXPECT_EQ(counts(world), counts(undisturbed)); };
    failures += run_out_of_memory([&] { world.add_shape(box); }, check);
    undisturbed.add_shape(box);
    failures += run_out_of_memory([&] { world.add_half_space({Vector::UnitZ(), 0.1 * step}); }, check);
    undisturbed.add_half_space({Vector::UnitZ(), 0.1 * step});
    failures += run_out_of_memory([&] { world.add_body(ShapeId{0}, shift(0.4 * step)); }, check);
    const BodyId last = undisturbed.add_body(ShapeId{0}, shift(0.4 * step));
    both([&](World& w) {
      w.set_awake(last, step % 2 == 0);
      if (step == 7) w.remove_body(BodyId{0});
    });
    WorldSnapshot taken;
    failures += run_out_of_memory([&] { world.snapshot(taken); }, check);
    World other;
    failures += run_out_of_memory([&] { other.restore(taken); }, [&] { EXPECT_EQ(other.body_count(), 0); });
    seen.clear();
    const CandidateOptions options{.ended = keep};
    failures += run_out_of_memory([&] { world.find_candidates(options, keep); }, [&] { EXPECT_TRUE(seen.empty()); });
    const std::vector<Found> expected = events(undisturbed);
    EXPECT_EQ(seen, expected) << "step " << step;
    EXPECT_EQ(events(other), expected) << "step " << step;
  }
  EXPECT_GT(failures, 100);
}

TEST(WorldErrors, NameTheGenerationOfAStaleId) {
  World world;
  const ShapeId shape = world.add_shape(sample_shape("box"));
  std::vector<BodyId> lives;
  std::vector<ShapeId> shapes;
  std::vector<HalfSpaceId> planes;
  for (int i = 0; i < 4; ++i) {
    if (i > 0) {
      world.remove_body(lives.back());
      world.remove_shape(shapes.back());
      world.remove_half_space(planes.back());
    }
    lives.push_back(world.add_body(shape, shift(0)));
    shapes.push_back(world.add_shape(sample_shape("box")));
    planes.push_back(world.add_half_space({}));
    EXPECT_EQ(index(lives.back()), 0u);
    EXPECT_EQ(index(shapes.back()), 1u);
    EXPECT_EQ(index(planes.back()), 0u);
    EXPECT_EQ(generation(lives.back()), static_cast<unsigned>(i));
  }
  EXPECT_EQ(error_of([&] { world.remove_body(lives[0]); }), "body 0: was removed");
  EXPECT_EQ(error_of([&] { world.remove_body(lives[2]); }), "body 0 (generation 2): was removed");
  EXPECT_EQ(error_of([&] { world.remove_shape(shapes[2]); }), "shape 1 (generation 2): was removed");
  EXPECT_EQ(error_of([&] { world.set_shape(lives[3], shapes[1]); }),
            "body 0 (generation 3): shape 1 (generation 1) was removed");
  EXPECT_EQ(error_of([&] { (void)world.half_space(planes[1]); }), "half-space 0 (generation 1): was removed");
  const auto never = static_cast<BodyId>(std::uint64_t{9} << 32);
  EXPECT_EQ(error_of([&] { world.remove_body(never); }), "body 0 (generation 9): does not exist");
  world.set_shape(lives[3], shapes[3]);
  world.remove_shape(shape);
  EXPECT_EQ(error_of([&] { world.remove_shape(shapes[3]); }), "shape 1 (generation 3): body 0 (generation 3) has it");
  EXPECT_EQ(world.body_count(), 1);
  EXPECT_EQ(world.shape_count(), 1);
  EXPECT_EQ(world.half_space_count(), 1);
}

}  // namespace
}  // namespace encage::test
