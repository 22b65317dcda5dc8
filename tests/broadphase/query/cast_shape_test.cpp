// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/query/ask_body.h"
#include "tests/broadphase/shape/stored_samples.h"

#include <encage/casts.h>
#include <encage/shape_cache.h>

#include <gtest/gtest.h>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

Motion moving(const Eigen::Isometry3d& start, const Vector& way) {
  Motion motion{start, start};
  motion.end.translation() += way;
  return motion;
}

TEST(CastShape, AgreesWithExactArithmeticAtTheStartAndWithSampledTimes) {
  const std::vector<Body> bodies = query_bodies();
  shapes::Random random(61);
  const int count = question_count("ENCAGE_QUERY_SHAPE_CASTS", 400);
  int hits = 0, misses = 0, overlapping = 0;
  for (int i = 0; i < count; ++i) {
    const auto any = [&]() -> const Body& {
      return bodies[static_cast<std::size_t>(
          random.integer(static_cast<int>(std::min<std::size_t>(8, bodies.size()))))];
    };
    const Body &a = any(), &b = any();
    const Eigen::Isometry3d at = random_pose(random, 1);
    Motion motion_a = moving(at, random.point(2)), motion_b = moving(random_pose(random, 2), random.point(2));
    if (random.integer(4) == 0) motion_a = random_motion(random, at, 1, 2);
    if (random.integer(4) == 0) motion_b.scale = random(0.1, 3);
    const bool solid = random.integer(4) > 0;
    const ShapeCastResult found = cast_shape(*a.shape, motion_a, *b.shape, motion_b, {.solid = solid});
    SCOPED_TRACE(a.sample.name + ", " + b.sample.name + ", " + std::to_string(i));
    const ExactBody exact_a(a.origin(), a.mesh(), motion_a.start, motion_a.scale);
    const ExactBody exact_b(b.origin(), b.mesh(), motion_b.start, motion_b.scale);
    const bool crossing = surfaces_meet(exact_a, exact_b, 0);
    const bool held = !crossing && ((b.solid() && holds_component(exact_b, exact_a)) ||
                                    (a.solid() && holds_component(exact_a, exact_b)));
    switch (found.answer) {
      case CastAnswer::overlapping:
        EXPECT_TRUE(crossing || (solid && held));
        EXPECT_EQ(found.time, 0);
        ++overlapping;
        continue;
      case CastAnswer::unknown:
        EXPECT_TRUE(solid && !(a.solid() && b.solid()));
        EXPECT_FALSE(found.exhausted);
        continue;
      case CastAnswer::miss:
        EXPECT_EQ(found.time, 1);
        ++misses;
        break;
      case CastAnswer::hit:
        EXPECT_EQ(found.time, found.contact.time);
        ++hits;
        break;
    }
    EXPECT_FALSE(crossing && found.time > 0);
    EXPECT_FALSE(solid && held);
    // Up to the time of the answer the surfaces are apart.
    for (int k = 0; k < 6; ++k) {
      const Real t = found.time * k / 6;
      const auto ta = at_time(a.mesh(), a.origin(), motion_a, t), tb = at_time(b.mesh(), b.origin(), motion_b, t);
      for (const RealTriangle& x : ta) {
        for (const RealTriangle& y : tb) {
          if (found.time > 0 && distance_bound(x, y) <= 0) {
            ASSERT_GT(triangle_distance(x, y), 0);
          }
        }
      }
    }
    if (found.answer == CastAnswer::hit) {
      const auto ta = at_time(a.mesh(), a.origin(), motion_a, found.time),
                 tb = at_time(b.mesh(), b.origin(), motion_b, found.time);
      Real least = 1;
      for (const RealTriangle& x : ta) {
        for (const RealTriangle& y : tb) {
          if (distance_bound(x, y) < least) least = std::min(least, triangle_distance(x, y));
        }
      }
      EXPECT_LE(least, 1e-5 * (a.diagonal() + b.diagonal()));
    }
  }
  EXPECT_GT(hits, count / 10);
  EXPECT_GT(misses, count / 10);
  EXPECT_GT(overlapping, count / 10);
}

TEST(CastShape, NamesWhatOverlapsAtTheStart) {
  const std::vector<Body> bodies = sample_bodies();
  const ShapePtr box = find(bodies, "box").shape, torus = find(bodies, "torus").shape;
  const auto ask = [&](const Motion& a, const Motion& b, const ShapeCastOptions& options = {}) {
    return cast_shape(*box, a, *box, b, options);
  };
  const Vector away(9, 0, 0);
  const Motion still;
  Motion small = moving(shift(0), away);
  small.scale = 0.25;
  const ShapeCastResult crossing = ask(moving(shift(1.5, 0.25, 0.125), away), still);
  EXPECT_EQ(crossing.answer, CastAnswer::overlapping);
  EXPECT_TRUE(crossing.contact.overlapping);
  // One in the other, with and without a touch of their surfaces, now or later.
  EXPECT_EQ(ask(small, still).answer, CastAnswer::overlapping);
  EXPECT_EQ(ask(still, small).answer, CastAnswer::overlapping);
  Motion resting = Motion::resting(shift(0), 0.25);
  EXPECT_EQ(ask(resting, still).answer, CastAnswer::overlapping);
  resting = Motion::resting(shift(0.75), 0.25);
  EXPECT_EQ(ask(resting, still).answer, CastAnswer::overlapping) << "at a wall, from inside";
  EXPECT_EQ(ask(still, still).answer, CastAnswer::hit) << "the same place: surfaces touch, neither holds a vertex";
  // Surfaces alone.
  EXPECT_EQ(ask(Motion::resting(shift(0), 0.25), still, {.solid = false}).answer, CastAnswer::miss);
  const ShapeCastResult within = ask(small, still, {.solid = false});
  EXPECT_EQ(within.answer, CastAnswer::hit);
  EXPECT_NEAR(within.time, 0.75 / 9, 1e-5);
  const Body hollow(find(bodies, "box").sample, 1, true);
  EXPECT_EQ(cast_shape(*box, small, *hollow.shape, still).answer, CastAnswer::hit);
  EXPECT_EQ(cast_shape(*box, Motion::resting(shift(0), 0.01), *torus, still).answer, CastAnswer::miss) << "in the hole";
}

TEST(CastShape, TouchesAtTheStartAreHits) {
  const ShapePtr box = find(sample_bodies(), "box").shape;
  for (const Vector& way : {Vector(1, 0, 0), Vector(-1, 0, 0), Vector(0, 1, 0), Vector(0, 0, 0)}) {
    const ShapeCastResult found = cast_shape(*box, moving(shift(2, 0.25), way), *box, Motion{});
    ASSERT_EQ(found.answer, CastAnswer::hit);
    EXPECT_EQ(found.time, 0);
    if (way.x() < 0) {
      EXPECT_NEAR(found.contact.normal.x(), 1, 1e-9);
    }
  }
  const ShapeCastResult falling = cast_shape(*box, moving(shift(4, 0.25), {-4, 0, 0}), *box, Motion{});
  EXPECT_EQ(falling.answer, CastAnswer::hit);
  EXPECT_NEAR(falling.time, 0.5, 1e-5);
  EXPECT_EQ(cast_shape(*box, moving(shift(4, 0.25), {-4, 0, 0}), *box, Motion{}, {.latest = 0.25}).answer,
            CastAnswer::miss);
  const ShapeCastResult margin = cast_shape(*box, moving(shift(4, 0.25), {-4, 0, 0}), *box, Motion{}, {.margin = 1});
  EXPECT_NEAR(margin.time, 0.25, 1e-5);
  EXPECT_EQ(cast_shape(*box, moving(shift(4), {1, 0, 0}), *box, Motion{}, {.margin = 3}).time, 0);
  EXPECT_EQ(cast_shape(*box, moving(shift(4), {0, 9, 0}), *box, Motion{}).answer, CastAnswer::miss);
}

TEST(CastShape, SaysWhatItDoesNotKnow) {
  const std::vector<Body> bodies = sample_bodies();
  const ShapePtr box = find(bodies, "box").shape, open = find(bodies, "open box").shape;
  const auto expect_unknown = [](const ShapeCastResult& found, bool exhausted = false) {
    EXPECT_EQ(found.answer, CastAnswer::unknown);
    EXPECT_EQ(found.time, 0);
    EXPECT_EQ(found.exhausted, exhausted);
  };
  Motion small = moving(shift(0), {5, 0, 0});
  small.scale = 0.1;
  expect_unknown(cast_shape(*box, small, *open, Motion{}));
  EXPECT_NE(cast_shape(*box, small, *open, Motion{}, {.solid = false}).answer, CastAnswer::unknown);
  Motion skew;
  skew.end.linear()(0, 1) = 0.1;
  expect_unknown(cast_shape(*box, skew, *box, moving(shift(9), {0, 0, 0})));
  const double not_a_number = std::numeric_limits<double>::quiet_NaN();
  const Motion far = moving(shift(9), {0, 0, 0});
  EXPECT_EQ(cast_shape(*box, far, *box, Motion{}).answer, CastAnswer::miss);
  for (const double x : {-1.0, not_a_number, 1e151}) {
    expect_unknown(cast_shape(*box, far, *box, Motion{}, {.margin = x}));
    expect_unknown(cast_shape(*box, far, *box, Motion{}, {.arc = x}));
    expect_unknown(cast_shape(*box, far, *box, Motion{}, {.latest = x}));
  }
  expect_unknown(cast_shape(*box, far, *box, Motion{}, {.most_steps = -1}));
  // The budget.
  const Motion near = moving(shift(2.5, 0.25), {-1, 0, 0});
  EXPECT_EQ(cast_shape(*box, near, *box, Motion{}).answer, CastAnswer::hit);
  const ShapeCastResult spent = cast_shape(*box, near, *box, Motion{}, {.most_steps = 0});
  EXPECT_EQ(spent.answer, CastAnswer::unknown);
  EXPECT_TRUE(spent.exhausted);
  EXPECT_LE(spent.time, 0.5);
  // Cages alone.
  for (const Sample& sample : sample_shapes(0)) {
    if (sample.hierarchy.levels.empty() || sample.hierarchy.fine.triangles.rows() == 0) continue;
    const ShapePtr cages = make_shape(without_fine(sample).hierarchy);
    expect_unknown(cast_shape(*cages, Motion{}, *box, Motion{}));
    EXPECT_EQ(cast_shape(*cages, Motion{}, *box, moving(shift(1e4), {1, 0, 0})).answer, CastAnswer::miss);
  }
}

TEST(CastShape, AMeshThatCannotBeReadIsUnknown) {
  const StoredSamples stored;
  ShapeCache cache({.budget_bytes = std::int64_t{1} << 40, .mode = LoadMode::copy});
  const ShapePtr shape = cache.load(stored.files[0]);
  std::filesystem::resize_file(stored.files[0], std::filesystem::file_size(stored.files[0]) / 2);
  const ShapePtr box = find(sample_bodies(), "box").shape;
  EXPECT_EQ(cast_shape(*shape, Motion{}, *box, Motion{}).answer, CastAnswer::unknown);
  EXPECT_EQ(cast_shape(*shape, Motion{}, *box, moving(shift(100), {1, 0, 0})).answer, CastAnswer::miss);
}

}  // namespace
}  // namespace encage::test
