// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/broadphase/primitives/true_body.h"

#include <encage/primitives.h>
#include <encage/queries.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

/// A primitive in a place, and the rounding that <encage/queries.h> promises there.
struct Asked {
  const TrueBody& body;
  Motion motion;
  TruePlaced truth;

  Asked(const TrueBody& b, const Motion& m) : body(b), motion(m), truth(at(b, m)) {}
  double unit() const { return motion.scale; }
  /// Of the truth, in the world, with what poses that are not quite rigid and float32 vertices make of the radius.
  double error(const Vector& point) const {
    return 2 * unit() * body.error + 4e-8 * unit() +
           1e-13 * (motion.start.translation().norm() + 3 * unit() + point.norm());
  }
};

/// Calls check(const Asked&) for all primitives in many places.
template <class Check>
void for_each_place(shapes::Random& random, int places, Check&& check) {
  const std::vector<TrueBody> all = primitives();
  for (const TrueBody& body : all) {
    for (int i = 0; i < places; ++i) {
      SCOPED_TRACE(body.name + " " + std::to_string(i));
      const double unit = std::pow(10, random(-2, 2));
      check(Asked(body, Motion::resting(rigid_pose(random, unit * (i % 3 == 0 ? 1e5 : 1)), unit)));
    }
  }
}

/// Points around a body, in it, on its surface, and where its core has its features.
std::vector<Vector> points_about(const Asked& asked, shapes::Random& random) {
  std::vector<Vector> points;
  const auto world = [&](const Point& p) { return Vector(p.cast<double>()); };
  for (const RealTriangle& t : asked.truth.triangles) {
    if (points.size() > 60) break;
    const Vector a = world(t[0]), b = world(t[1]), c = world(t[2]);
    for (const Vector& on : {a, Vector(0.5 * (a + b)), Vector((a + b + c) / 3)}) {
      const Vector way = random_direction(random);
      const double radius = static_cast<double>(asked.truth.radius);
      points.push_back(on);
      points.emplace_back(on + (radius + asked.unit() * std::pow(10, random(-14, 0)) * random(-1, 1)) * way);
      points.emplace_back(on + random(0, 3) * radius * way);
      points.emplace_back(on + asked.unit() * std::pow(10, random(-14, 0)) * way);
    }
  }
  return points;
}

TEST(RoundedQueries, DistancesAreBoundsAndSidesAreRight) {
  shapes::Random random(1);
  int inside = 0, outside = 0;
  for_each_place(random, 6, [&](const Asked& asked) {
    const Shape& shape = *asked.body.shape;
    for (const Vector& p : points_about(asked, random)) {
      const double truth = static_cast<double>(signed_to(asked.truth, real(p))), error = asked.error(p);
      const double slack = asked.unit() * asked.body.error + 1e-15 * p.norm();
      const SignedDistance found = signed_distance(shape, asked.motion, p);
      ASSERT_LE(found.lower, truth + slack);
      ASSERT_GE(found.upper, truth - slack);
      ASSERT_LE(found.upper - found.lower, 2 * error + (found.side == PointSide::unknown ? 2 * error : 0));
      if (found.side == PointSide::inside) {
        ASSERT_LT(truth, slack);
      }
      if (found.side == PointSide::outside) {
        ASSERT_GT(truth, -slack);
      }
      if (std::abs(truth) > 2 * error) {
        ASSERT_NE(found.side, PointSide::unknown);
      }
      if (asked.body.radius > 0) {
        ASSERT_EQ(contains(shape, asked.motion, p), found.side);
      }
      inside += found.side == PointSide::inside ? 1 : 0;
      outside += found.side == PointSide::outside ? 1 : 0;

      const ClosestPoint closest = closest_point(shape, asked.motion, p);
      ASSERT_LE(closest.lower, std::abs(truth) + slack);
      ASSERT_GE(closest.upper, std::abs(truth) - slack);
      ASSERT_TRUE(closest.found());
      ASSERT_LT(closest.triangle, static_cast<std::int32_t>(asked.body.triangles.size()));
      ASSERT_LE(std::abs(static_cast<double>(signed_to(asked.truth, real(closest.point)))), 4 * error);
      ASSERT_LE((closest.point - p).norm(), closest.upper + 4 * error + 1e-9 * (p.norm() + asked.unit()));
      const double limit = 0.5 * std::abs(truth);
      if (!(limit > 2 * error)) continue;
      const ClosestPoint limited = closest_point(shape, asked.motion, p, {.limit = limit});
      ASSERT_FALSE(limited.found());
      ASSERT_GE(limited.lower, limit - error);
      ASSERT_EQ(limited.upper, infinity);
      ASSERT_EQ(signed_distance(shape, asked.motion, p, {.limit = limit}).side, found.side);
    }
  });
  EXPECT_GT(inside, 500);
  EXPECT_GT(outside, 300);
}

TEST(RoundedQueries, VolumesOverlapWhereTheyAreNear) {
  shapes::Random random(2);
  for_each_place(random, 6, [&](const Asked& asked) {
    for (const Vector& p : points_about(asked, random)) {
      const double truth = static_cast<double>(signed_to(asked.truth, real(p))), error = asked.error(p);
      const double radius = std::abs(truth) * random(0.5, 1.5);
      const bool found = overlaps(*asked.body.shape, asked.motion, Sphere{p, radius});
      if (truth < radius - error) {
        ASSERT_TRUE(found);
      }
      if (truth > radius + 2 * error) {
        ASSERT_FALSE(found);
      }
      // A capsule that ends there.
      const Vector end = p + random(0, 2) * asked.unit() * random_direction(random);
      if (truth < radius - error) {
        ASSERT_TRUE(overlaps(*asked.body.shape, asked.motion, Capsule{end, p, radius}));
      }
    }
  });
}

// ---- Rays --------------------------------------------------------------------

/// Rays at a body, half of them along its surface, from inside, and with both ends near it.
Ray ray_at(const Asked& asked, Vector target, shapes::Random& random) {
  Ray ray;
  Vector direction = random_direction(random);
  const Vector on = closest_point(*asked.body.shape, asked.motion, target).point;
  if (random(0, 1) < 0.5 && (target - on).norm() > 1e-6 * asked.unit()) {
    const Vector normal = (target - on).normalized();
    direction = (direction - direction.dot(normal) * normal).normalized();
    target = on + asked.unit() * std::pow(10, random(-14, -2)) * random(-1, 1) * normal;
  }
  ray.direction = direction * std::pow(10, random(-3, 3));
  const double t = random(-1, 6) * asked.unit() / ray.direction.norm();
  ray.origin = target - t * ray.direction;
  if (random(0, 1) < 0.2) ray.t_max = t * random(0.9, 1.1);
  if (random(0, 1) < 0.2) ray.t_min = -infinity;
  return ray;
}

TEST(RoundedQueries, RaysMissNothing) {
  shapes::Random random(3);
  int hits = 0, misses = 0, grazing = 0;
  for_each_place(random, 6, [&](const Asked& asked) {
    if (asked.body.radius == 0) return;
    for (const Vector& target : points_about(asked, random)) {
      const Ray ray = ray_at(asked, target, random);
      const double length = ray.direction.norm(),
                   error = 1e-12 * (asked.motion.start.translation().norm() + ray.origin.norm()) + asked.error(target);
      const double middle =
          (Vector((asked.truth.triangles[0][0]).cast<double>()) - ray.origin).dot(ray.direction) / length / length;
      const double from = std::max(ray.t_min, middle - 20 * asked.unit() / length),
                   to = std::min(ray.t_max, middle + 20 * asked.unit() / length);
      const auto depth = [&](Real t) { return signed_to(asked.truth, real(ray.origin) + t * real(ray.direction)); };
      const RayResult found = cast_ray(*asked.body.shape, asked.motion, ray);
      ASSERT_NE(found.answer, RayAnswer::unknown);
      if (!(from <= to)) {
        ASSERT_EQ(found.answer, RayAnswer::miss);
        continue;
      }
      // The signed distance is convex along the ray: its least value is found by narrowing.
      Real low = from, high = to;
      for (int i = 0; i < 60; ++i) {
        const Real a = low + (high - low) * Real(0.382), b = low + (high - low) * Real(0.618);
        if (depth(a) < depth(b)) {
          high = b;
        } else {
          low = a;
        }
      }
      const double least = static_cast<double>(depth((low + high) / 2)), at_from = static_cast<double>(depth(from)),
                   at_to = static_cast<double>(depth(to));
      if (found.answer == RayAnswer::miss) {
        ++misses;
        // It stays outside, or inside.
        ASSERT_TRUE(std::min({least, at_from, at_to}) > -error || std::max(at_from, at_to) < error);
        ASSERT_EQ(all_hits(*asked.body.shape, asked.motion, ray, {}).count, 0);
        continue;
      }
      ++hits;
      grazing += std::abs(least) < 1e-3 * asked.unit() ? 1 : 0;
      const RayHit& hit = found.hit;
      ASSERT_GE(hit.t, ray.t_min);
      ASSERT_LE(hit.t, ray.t_max);
      ASSERT_LE(std::abs(static_cast<double>(depth(hit.t))), 4 * error);
      ASSERT_NEAR(hit.normal.norm(), 1, 1e-12);
      // Before it the ray is outside; if it meets the surface from behind, inside.
      const auto side = [&](Real t) { return static_cast<double>(depth(t)) * (hit.back_face ? -1 : 1); };
      for (int i = 0; i < 12; ++i) ASSERT_GT(side(from + (Real(hit.t) - from) * i / 12), -4 * error);
      // Normals lead outward.
      const Vector place = ray.origin + hit.t * ray.direction;
      if (static_cast<double>(asked.truth.radius) > 1e5 * error) {
        const Vector outer = place + 1e-3 * static_cast<double>(asked.truth.radius) * hit.normal;
        ASSERT_NEAR(static_cast<double>(signed_to(asked.truth, real(outer)) / asked.truth.radius), 1e-3, 1e-4);
      }
      ASSERT_NEAR(hit.barycentric[0] + hit.barycentric[1] + hit.barycentric[2], 1, 1e-12);

      RayHit room[3];
      const RayHits all = all_hits(*asked.body.shape, asked.motion, ray, room);
      ASSERT_GE(all.count, 1);
      ASSERT_LE(all.count, 2);
      ASSERT_EQ(room[0].t, hit.t);
      if (all.count == 2) {
        ASSERT_LE(std::abs(static_cast<double>(depth(room[1].t))), 4 * error);
        ASSERT_TRUE(room[1].back_face);
      } else if (!hit.back_face) {
        // It ends inside, or touches.
        ASSERT_TRUE(at_to < error || least > -error || std::abs(at_to) < error);
      }
      const RayResult front = cast_ray(*asked.body.shape, asked.motion, ray, {.back_faces = BackFaces::ignore});
      ASSERT_EQ(front.answer, hit.back_face ? RayAnswer::miss : RayAnswer::hit);
      if (!hit.back_face) {
        ASSERT_EQ(front.hit.t, hit.t);
      }
    }
  });
  EXPECT_GT(hits, 400);
  EXPECT_GT(misses, 100);
  EXPECT_GT(grazing, 100);
}

TEST(RoundedQueries, ABallIsHitWhereItShouldBe) {
  const ShapePtr ball = make_sphere(0.5);
  const Motion motion = Motion::resting(shift(1, 2, 3), 2);
  RayResult found = cast_ray(*ball, motion, {.origin = {1, 2, 13}, .direction = {0, 0, -2}});
  ASSERT_EQ(found.answer, RayAnswer::hit);
  EXPECT_NEAR(found.hit.t, 4.5, 1e-12);
  EXPECT_LT((found.hit.normal - Vector::UnitZ()).norm(), 1e-12);
  EXPECT_FALSE(found.hit.back_face);
  found = cast_ray(*ball, motion, {.origin = {1, 2, 3}, .direction = {0, 0, -2}});
  ASSERT_EQ(found.answer, RayAnswer::hit);
  EXPECT_NEAR(found.hit.t, 0.5, 1e-12);
  EXPECT_TRUE(found.hit.back_face);
  EXPECT_EQ(cast_ray(*ball, motion, {.origin = {2 + 1e-9, 2, 13}, .direction = {0, 0, -2}}).answer, RayAnswer::miss);
  EXPECT_EQ(cast_ray(*ball, motion, {.origin = {2 - 1e-9, 2, 13}, .direction = {0, 0, -2}}).answer, RayAnswer::hit);
  EXPECT_EQ(cast_ray(*ball, motion, {.origin = {1, 2, 13}, .direction = {0, 0, 2}}).answer, RayAnswer::miss);
  EXPECT_EQ(cast_ray(*ball, motion, {.origin = {1, 2, 13}, .direction = {0, 0, -2}, .t_max = 4.4}).answer,
            RayAnswer::miss);
  const ClosestPoint middle = closest_point(*ball, motion, {1, 2, 3});
  EXPECT_NEAR(middle.upper, 1, 1e-7);
  EXPECT_NEAR((middle.point - Vector(1, 2, 3)).norm(), 1, 1e-12);
}

TEST(RoundedQueries, CompoundsAreAskedPartByPart) {
  shapes::Random random(4);
  const std::vector<TrueBody> all = primitives();
  for (int i = 0; i < 40; ++i) {
    std::vector<CompoundPart> parts;
    std::vector<TruePlaced> truth;
    for (int k = 0; k < 6; ++k) {
      const TrueBody& part = all[static_cast<std::size_t>(random(0, 9.999))];
      if (part.error > 1e-3) continue;
      parts.push_back({part.shape, rigid_pose(random, 2), random(0.2, 1)});
      truth.push_back(at(part, Motion::resting(parts.back().pose, parts.back().scale)));
    }
    const ShapePtr compound = make_compound(parts);
    for (int k = 0; k < 40; ++k) {
      const Vector p = random.point(3);
      Real least = infinity, nearest = infinity;
      for (const TruePlaced& part : truth) {
        const Real own = signed_to(part, real(p));
        least = std::min(least, own);
        nearest = std::min(nearest, std::abs(own));
      }
      const PointSide side = contains(*compound, {}, p);
      EXPECT_EQ(side, least < 0 ? PointSide::inside : PointSide::outside);
      const ClosestPoint closest = closest_point(*compound, {}, p);
      EXPECT_NEAR(closest.upper, static_cast<double>(nearest), 1e-6);
      EXPECT_NEAR(signed_distance(*compound, {}, p).lower, static_cast<double>(least), 1e-6);
      const Ray ray{.origin = p, .direction = random_direction(random)};
      const RayResult found = cast_ray(*compound, {}, ray);
      double first = infinity;
      for (std::size_t part = 0; part < parts.size(); ++part) {
        const RayResult own = cast_ray(*parts[part].shape, Motion::resting(parts[part].pose, parts[part].scale), ray);
        if (own.answer == RayAnswer::hit) first = std::min(first, own.hit.t);
      }
      ASSERT_EQ(found.answer, first < infinity ? RayAnswer::hit : RayAnswer::miss);
      if (first < infinity) {
        EXPECT_NEAR(found.hit.t, first, 1e-9);
      }
    }
  }
}

}  // namespace
}  // namespace encage::test
