// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/query/ask_body.h"
#include "tests/broadphase/shape/stored_samples.h"

#include <encage/shape_cache.h>

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double endless = std::numeric_limits<double>::infinity();

ShapePtr sample_box() { return find(sample_bodies(), "box").shape; }

TEST(QueryInput, RaysThatAreNoneAreUnknown) {
  const ShapePtr box = sample_box();
  const auto ask = [&](const Ray& ray, const Motion& motion = {}) {
    const RayResult result = cast_ray(*box, motion, ray);
    std::vector<RayHit> hits(8);
    EXPECT_EQ(all_hits(*box, motion, ray, hits).answer, result.answer);
    return result.answer;
  };
  const Vector origin(0, 0, -5), up(0, 0, 1);
  EXPECT_EQ(ask({origin, up}), RayAnswer::hit);
  EXPECT_EQ(ask({origin, Vector(0, 0, 0)}), RayAnswer::unknown);
  EXPECT_EQ(ask({origin, Vector(0, nan, 1)}), RayAnswer::unknown);
  EXPECT_EQ(ask({origin, Vector(0, endless, 1)}), RayAnswer::unknown);
  EXPECT_EQ(ask({Vector(0, 0, nan), up}), RayAnswer::unknown);
  EXPECT_EQ(ask({Vector(0, 0, 1e151), up}), RayAnswer::unknown);
  EXPECT_EQ(ask({origin, up, nan}), RayAnswer::unknown);
  EXPECT_EQ(ask({origin, up, 0, nan}), RayAnswer::unknown);
  EXPECT_EQ(ask({origin, up, 2, 1}), RayAnswer::miss);
  EXPECT_EQ(ask({origin, up, -endless, endless}), RayAnswer::hit);
  EXPECT_EQ(ask({origin, up, endless, endless}), RayAnswer::miss);
  Motion mirrored;
  mirrored.start.linear()(0, 0) = -1;
  EXPECT_EQ(ask({origin, up}, mirrored), RayAnswer::unknown);
  EXPECT_EQ(ask({origin, up}, Motion::resting(Eigen::Isometry3d::Identity(), 0)), RayAnswer::unknown);
}

TEST(QueryInput, DirectionsOfAnyLength) {
  const ShapePtr box = sample_box();
  for (const double length : {1e-320, 1e-300, 1e-20, 1.0, 1e20, 1e300}) {
    const RayResult found = cast_ray(*box, Motion{}, {Vector(0.25, 0.5, -5), Vector(0, 0, length)});
    ASSERT_EQ(found.answer, RayAnswer::hit) << length;
    EXPECT_NEAR(std::min(4 / length, std::numeric_limits<double>::max()) / found.hit.t, 1, 1e-12) << length;
    EXPECT_EQ(cast_ray(*box, Motion{}, {Vector(0.25, 0.5, -5), Vector(0, length, 0)}).answer, RayAnswer::miss);
  }
  // From as far as rays may begin.
  EXPECT_EQ(cast_ray(*box, Motion{}, {Vector(0, 0, -1e150), Vector(0, 0, 1)}).answer, RayAnswer::hit);
  EXPECT_EQ(cast_ray(*box, Motion{}, {Vector(1e150, 0, -1e150), Vector(0, 0, 1)}).answer, RayAnswer::miss);
}

TEST(QueryInput, PointsThatAreNoneHaveNoSide) {
  const ShapePtr box = sample_box();
  for (const Vector& p : {Vector(nan, 0, 0), Vector(0, endless, 0), Vector(0, 0, 1e151)}) {
    EXPECT_EQ(contains(*box, Motion{}, p), PointSide::unknown);
    const ClosestPoint closest = closest_point(*box, Motion{}, p);
    EXPECT_FALSE(closest.found());
    EXPECT_EQ(closest.lower, 0);
    EXPECT_EQ(closest.upper, endless);
    const SignedDistance with_sign = signed_distance(*box, Motion{}, p);
    EXPECT_EQ(with_sign.side, PointSide::unknown);
    EXPECT_EQ(with_sign.lower, -endless);
    EXPECT_EQ(with_sign.upper, endless);
  }
  for (const double limit : {0.0, -1.0, nan}) {
    EXPECT_FALSE(closest_point(*box, Motion{}, Vector(3, 0, 0), {.limit = limit}).found());
    EXPECT_EQ(closest_point(*box, Motion{}, Vector(3, 0, 0), {.limit = limit}).lower, 0);
  }
  Motion skew;
  skew.start.linear()(0, 1) = 0.1;
  EXPECT_EQ(contains(*box, skew, Vector(0, 0, 0)), PointSide::unknown);
  EXPECT_FALSE(closest_point(*box, skew, Vector(0, 0, 0)).found());
  // Far away, where squares leave the range of float.
  const ClosestPoint far = closest_point(*box, Motion{}, Vector(1e140, 0, 0));
  EXPECT_TRUE(far.found());
  EXPECT_NEAR(far.upper / 1e140, 1, 1e-12);
  EXPECT_NEAR(closest_point(*box, Motion{}, Vector(1e25, 0.25, 0.25)).upper / 1e25, 1, 1e-12);
  EXPECT_EQ(closest_point(*box, Motion{}, Vector(1e12, 0.25, 0.25)).point.x(), 1);
}

TEST(QueryInput, VolumesThatAreNoneMayOverlap) {
  const ShapePtr box = sample_box();
  const Vector far(10, 0, 0);
  EXPECT_FALSE(overlaps(*box, Motion{}, Sphere{far, 1}));
  for (const double radius : {-1.0, nan, endless}) {
    EXPECT_TRUE(overlaps(*box, Motion{}, Sphere{far, radius}));
    EXPECT_TRUE(overlaps(*box, Motion{}, Capsule{far, far, radius}));
    EXPECT_TRUE(overlaps(*box, Motion{}, OrientedBox{shift(10), {1, 1, radius}}));
    EXPECT_TRUE(overlaps(*box, Motion{}, std::vector<Vector>{far}, radius));
  }
  EXPECT_TRUE(overlaps(*box, Motion{}, Sphere{{nan, 0, 0}, 1}));
  OrientedBox mirrored{shift(10), {1, 1, 1}};
  mirrored.pose.linear()(0, 0) = -1;
  EXPECT_TRUE(overlaps(*box, Motion{}, mirrored));
  EXPECT_TRUE(overlaps(*box, Motion{}, HalfSpace{{0, 0, 2}, -10}));
  EXPECT_TRUE(overlaps(*box, Motion{}, HalfSpace{{0, 0, 1}, nan}));
  EXPECT_FALSE(overlaps(*box, Motion{}, HalfSpace{{0, 0, 1}, -10}));
  EXPECT_FALSE(overlaps(*box, Motion{}, std::vector<Vector>{}));
  EXPECT_FALSE(overlaps(*box, Motion{}, std::vector<Vector>{far, far, far, far})) << "one point, four times";
  EXPECT_FALSE(overlaps(*box, Motion{}, std::vector<Vector>{far, {10, 1, 0}, {10, 2, 0}, {10, 3, 0}})) << "collinear";
  EXPECT_TRUE(overlaps(*box, Motion{}, std::vector<Vector>{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}, {3, 3, 0}}))
      << "coplanar";
}

/// What a shape without a fine mesh answers, and what it must not.
void check_cages_alone(const Shape& shape, const Body& whole) {
  shapes::Random random(41);
  int missed = 0, unknown = 0;
  for (int i = 0; i < 500; ++i) {
    const Vector p = random.point(3);
    const Ray ray{p, random.point(1)};
    const RayResult found = cast_ray(shape, Motion{}, ray);
    const RayResult truth = cast_ray(*whole.shape, Motion{}, ray);
    ASSERT_NE(found.answer, RayAnswer::hit);
    if (found.answer == RayAnswer::miss) {
      EXPECT_EQ(truth.answer, RayAnswer::miss);
      ++missed;
    } else {
      if (truth.answer == RayAnswer::hit) {
        EXPECT_LE(found.hit.t, truth.hit.t);
      }
      ++unknown;
    }
    const PointSide side = contains(shape, Motion{}, p);
    ASSERT_NE(side, PointSide::inside);
    const ClosestPoint closest = closest_point(shape, Motion{}, p);
    EXPECT_FALSE(closest.found());
    EXPECT_LE(closest.lower, closest_point(*whole.shape, Motion{}, p).upper);
    if (side == PointSide::outside) {
      EXPECT_EQ(contains(*whole.shape, Motion{}, p), whole.solid() ? PointSide::outside : side);
    }
    if (!overlaps(shape, Motion{}, Sphere{p, 0.1})) {
      EXPECT_FALSE(whole.solid() && overlaps(*whole.shape, Motion{}, Sphere{p, 0.1}));
    }
  }
  EXPECT_GT(missed, 50);
  EXPECT_GT(unknown, 5);
}

TEST(QueryInput, WithoutAFineMeshCagesAnswer) {
  for (const Sample& sample : sample_shapes(0)) {
    if (sample.hierarchy.levels.empty() || sample.hierarchy.fine.triangles.rows() == 0) continue;
    SCOPED_TRACE(sample.name);
    check_cages_alone(*make_shape(without_fine(sample).hierarchy), Body(sample));
  }
}

TEST(QueryInput, ShapesOfACacheAnswerLikeOthers) {
  const StoredSamples stored;
  ShapeCache cache({.budget_bytes = stored.room_for_a_pair(), .mode = LoadMode::copy});
  shapes::Random random(42);
  std::vector<ShapePtr> cached, loaded;
  for (const auto& file : stored.files) {
    cached.push_back(cache.load(file));
    loaded.push_back(load_shape(file));
  }
  for (int i = 0; i < 400; ++i) {
    const auto k = static_cast<std::size_t>(random.integer(static_cast<int>(cached.size())));
    const Vector p = random.point(2);
    const Ray ray{p, random.point(1)};
    const RayResult a = cast_ray(*cached[k], Motion{}, ray), b = cast_ray(*loaded[k], Motion{}, ray);
    EXPECT_EQ(a.answer, b.answer);
    EXPECT_EQ(a.hit.t, b.hit.t);
    EXPECT_EQ(a.hit.triangle, b.hit.triangle);
    // The bounds differ with the sizes that are known: with the cage's, or the fine mesh's.
    EXPECT_NEAR(closest_point(*cached[k], Motion{}, p).upper, closest_point(*loaded[k], Motion{}, p).upper, 1e-12);
    EXPECT_NEAR(signed_distance(*cached[k], Motion{}, p).lower, signed_distance(*loaded[k], Motion{}, p).lower, 1e-12);
    EXPECT_EQ(contains(*cached[k], Motion{}, p), contains(*loaded[k], Motion{}, p));
    EXPECT_EQ(overlaps(*cached[k], Motion{}, Sphere{p, 0.2}), overlaps(*loaded[k], Motion{}, Sphere{p, 0.2}));
  }
  EXPECT_GT(cache.statistics().evictions, 0);
}

TEST(QueryInput, AMeshThatCannotBeReadLeavesTheCages) {
  const StoredSamples stored;
  for (const auto& file : stored.files) {
    SCOPED_TRACE(file.filename().string());
    ShapeCache cache({.budget_bytes = std::int64_t{1} << 40, .mode = LoadMode::copy});
    const ShapePtr shape = cache.load(file);
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    EXPECT_NE(cast_ray(*shape, Motion{}, {Vector(0.01, 0.02, -5), Vector(0, 0, 1)}).answer, RayAnswer::hit);
    EXPECT_EQ(cast_ray(*shape, Motion{}, {Vector(9, 0, -5), Vector(0, 0, 1)}).answer, RayAnswer::miss);
    EXPECT_FALSE(closest_point(*shape, Motion{}, Vector(5, 0, 0)).found());
    EXPECT_GT(closest_point(*shape, Motion{}, Vector(5, 0, 0)).lower, 1);
    EXPECT_EQ(contains(*shape, Motion{}, Vector(5, 0, 0)), PointSide::outside);
    EXPECT_FALSE(overlaps(*shape, Motion{}, Sphere{{5, 0, 0}, 1}));
  }
}

TEST(QueryInput, SpansOfDifferentLengths) {
  const ShapePtr box = sample_box();
  const std::vector<Ray> rays(3, Ray{Vector(0.25, 0.5, -5), Vector(0, 0, 1)});
  std::vector<RayResult> results(2);
  cast_rays(*box, Motion{}, rays, results);
  EXPECT_EQ(results[1].answer, RayAnswer::hit);
  std::vector<RayResult> more(4);
  cast_rays(*box, Motion{}, rays, more);
  EXPECT_EQ(more[2].answer, RayAnswer::hit);
  EXPECT_EQ(more[3].answer, RayAnswer::unknown) << "as it was";
}

}  // namespace
}  // namespace encage::test
