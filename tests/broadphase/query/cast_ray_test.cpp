// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/shape/shape.h"
#include "oracles/count_allocations.h"
#include "oracles/simd_targets.h"
#include "tests/broadphase/query/ask_body.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

constexpr double no_end = std::numeric_limits<double>::infinity();

/// A ray at a body: at its middle, at a vertex, at a point of an edge, along an edge, or from a vertex.
Ray ray_at(const PlacedBody& body, shapes::Random& random, int kind) {
  const double size = body.box.diagonal().norm();
  const Vector middle = body.box.center();
  Ray ray;
  ray.origin = middle + random(0.1, 1.5) * size * random_direction(random);
  const auto t = static_cast<std::size_t>(random.integer(static_cast<int>(body.triangles.size())));
  const int k = random.integer(3);
  const Point a = body.triangles[t][k], b = body.triangles[t][(k + 1) % 3];
  Vector target;
  switch (kind) {
    case 0: target = a.cast<double>(); break;
    case 1: target = (a + Real(random(0, 1)) * (b - a)).cast<double>(); break;
    case 2: {  // along the edge, or along no direction at all for a degenerate one
      target = b.cast<double>();
      ray.origin = (a - Real(random(0, 2)) * (b - a)).cast<double>();
      break;
    }
    case 3: {
      ray.origin = a.cast<double>();
      target = middle + 0.5 * size * random_direction(random);
      break;
    }
    default: target = middle + random.point(0.3 * size); break;
  }
  ray.direction = (target - ray.origin) * std::exp(random(-5, 5));
  if (ray.direction.isZero(0)) ray.direction = random_direction(random);
  const double length = size / ray.direction.norm();
  switch (random.integer(8)) {
    case 0: ray.t_max = random(0, 2) * length; break;
    case 1: ray.t_min = -random(0, 2) * length; break;
    case 2: ray.t_min = -no_end; break;
    case 3: {  // ends, or begins, at the target
      const double at = (target - ray.origin).norm() / ray.direction.norm();
      (random.integer(2) == 0 ? ray.t_max : ray.t_min) = at;
      break;
    }
    default: break;
  }
  return ray;
}

/// Distance of a ray and a triangle, and a bound that costs less.
Real distance_to(const PlacedBody& body, std::size_t triangle, const Ray& ray, Real low, Real high) {
  const Point o = ray.origin.cast<Real>(), d = ray.direction.cast<Real>();
  return triangle_distance(body.triangles[triangle], {o + low * d, o + high * d, o + high * d});
}

bool is_thin(const RealTriangle& t) {
  const Real longest = std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  return (t[1] - t[0]).cross(t[2] - t[0]).norm() < 1e-2L * longest * longest;
}

struct RayCounts {
  int hits = 0, exact = 0, extra = 0;
};

void check_ray(const PlacedBody& body, const Ray& ray, RayCounts& counts) {
  const double rounding = body.rounding(ray.origin);
  const Point o = ray.origin.cast<Real>(), d = ray.direction.cast<Real>();
  const Real length = d.norm();
  // Beyond the ball around the body there is nothing to be met.
  const Real middle = (body.box.center().cast<Real>() - o).dot(d) / (length * length);
  const Real far = Real(body.box.diagonal().norm()) / length;
  const Real low = std::max<Real>(Real(ray.t_min), middle - far), high = std::min<Real>(Real(ray.t_max), middle + far);

  std::vector<RayHit> found(64);
  const RayHits all = all_hits(*body.shape, body.motion, ray, found);
  ASSERT_NE(all.answer, RayAnswer::unknown);
  ASSERT_LE(all.count, 64);
  found.resize(static_cast<std::size_t>(all.count));
  std::set<std::int32_t> reported;
  for (const RayHit& hit : found) reported.insert(hit.triangle);
  ASSERT_EQ(static_cast<std::int64_t>(reported.size()), all.count);

  counts.hits += all.count > 0;
  std::set<std::int32_t> exact;
  for (std::size_t t = 0; t < body.triangles.size(); ++t) {
    const Point from = body.centres[t] - o;
    const Real along = from.dot(d) / (length * length);
    if ((from - along * d).norm() > body.radii[t] * (1 + 1e-9L) + rounding) continue;
    const auto [part, i] = body.exact_triangle(t);
    const bool met = ray_meets(*part, i, {ray.origin, ray.direction, ray.t_min, ray.t_max});
    const bool is_reported = reported.count(static_cast<std::int32_t>(t)) > 0;
    counts.exact += met;
    if (met) exact.insert(static_cast<std::int32_t>(t));
    if (met) {
      ASSERT_TRUE(is_reported) << body.name << " misses triangle " << t;
    } else if (is_reported) {
      ++counts.extra;
      ASSERT_LE(low, high + rounding / length);
      EXPECT_LE(static_cast<double>(distance_to(body, t, ray, low, std::max(low, high))),
                is_thin(body.triangles[t]) ? 16 * rounding : rounding)
          << body.name << " triangle " << t;
    }
  }

  // What is said of each hit.
  for (std::size_t i = 0; i < found.size(); ++i) {
    const RayHit& hit = found[i];
    if (i > 0) {
      const RayHit& before = found[i - 1];
      EXPECT_TRUE(before.t < hit.t || (before.t == hit.t && before.triangle < hit.triangle));
    }
    ASSERT_GE(hit.t, ray.t_min);
    ASSERT_LE(hit.t, ray.t_max);
    const RealTriangle& t = body.triangles[static_cast<std::size_t>(hit.triangle)];
    const Point at = o + Real(hit.t) * d;
    const Point n = (t[1] - t[0]).cross(t[2] - t[0]);
    // Along the ray the place is as uncertain as the angle makes it.
    const Real sine = std::abs(n.dot(d)) / std::max(n.norm() * length, std::numeric_limits<Real>::min());
    const double place = rounding * (8 + 1 / std::max(static_cast<double>(sine), 1e-3));
    EXPECT_LE(static_cast<double>(point_triangle_distance(at, t)), place) << body.name;
    Point weighted = Point::Zero();
    Real sum = 0;
    for (int k = 0; k < 3; ++k) {
      ASSERT_GE(hit.barycentric[k], 0);
      weighted += Real(hit.barycentric[k]) * t[k];
      sum += Real(hit.barycentric[k]);
    }
    EXPECT_NEAR(static_cast<double>(sum), 1, 1e-14);
    if (sine > 1e-3L) {
      const Real width = n.norm() / body.radii[static_cast<std::size_t>(hit.triangle)];  // of which thin ones may lose
      const bool thin = width < 1e-7L * body.radii[static_cast<std::size_t>(hit.triangle)];
      EXPECT_LE(static_cast<double>((weighted - at).norm() - (thin ? width : 0)), 4 * place) << body.name;
    }
    if (n.norm() > 0 && n.norm() > 1e-6L * body.radii[static_cast<std::size_t>(hit.triangle)] *
                                       body.radii[static_cast<std::size_t>(hit.triangle)]) {
      EXPECT_LT((hit.normal.cast<Real>() - n.normalized()).norm(), 1e-8L) << body.name;
      if (sine > 1e-3L) {
        EXPECT_EQ(hit.back_face, n.dot(d) > 0) << body.name;
      }
    }
  }

  // The first hit is that of all.
  const RayResult first = cast_ray(*body.shape, body.motion, ray);
  ASSERT_EQ(first.answer, all.answer) << body.name;
  if (first.answer == RayAnswer::hit) {
    EXPECT_EQ(first.hit.t, found.front().t) << body.name;
    EXPECT_EQ(first.hit.triangle, found.front().triangle) << body.name;
    EXPECT_EQ(first.hit.barycentric, found.front().barycentric);
  }

  // Of one side only.
  const RayResult front = cast_ray(*body.shape, body.motion, ray, {.back_faces = BackFaces::ignore});
  const auto is_front = [](const RayHit& hit) { return !hit.back_face; };
  const auto expected = std::find_if(found.begin(), found.end(), is_front);
  if (expected != found.end()) {
    ASSERT_EQ(front.answer, RayAnswer::hit) << body.name;
    EXPECT_LE(front.hit.t, expected->t);
  } else if (front.answer == RayAnswer::hit) {
    const RealTriangle& t = body.triangles[static_cast<std::size_t>(front.hit.triangle)];
    const Point n = (t[1] - t[0]).cross(t[2] - t[0]);
    EXPECT_LE(n.dot(d), 1e-3L * n.norm() * length) << "seen edge on";
  }
}

TEST(CastRay, MissesNothingThatExactArithmeticFinds) {
  const std::vector<PlacedBody> bodies = placed_bodies(11);
  const int count = question_count("ENCAGE_QUERY_RAYS", 100'000);
  shapes::Random random(12);
  RayCounts aimed, others;
  for (int i = 0; i < count; ++i) {
    const PlacedBody& body = bodies[static_cast<std::size_t>(i) % bodies.size()];
    // A tenth is aimed at vertices and edges.
    const bool aim = random.integer(10) == 0;
    check_ray(body, ray_at(body, random, aim ? random.integer(4) : 4), aim ? aimed : others);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(aimed.hits, count / 20);
  EXPECT_GT(others.hits, count / 4);
  EXPECT_GT(others.exact, others.hits);
  EXPECT_LT(others.extra, others.exact / 1000) << "hits that only rounding allows";
}

// Coordinates are multiples of 1/8: rays hit vertices and edges exactly, and run in the planes of triangles.
TEST(CastRay, LatticeRaysMeetEdgesVerticesAndPlanes) {
  std::vector<PlacedBody> bodies;
  for (const Body& body : query_bodies()) bodies.push_back(placed(body, Motion{}));
  shapes::Random random(13);
  RayCounts counts;
  for (int i = 0; i < 20'000; ++i) {
    const PlacedBody& body = bodies[static_cast<std::size_t>(i) % bodies.size()];
    const double unit = std::exp2(std::round(std::log2(body.box.diagonal().norm() / 32)));
    const auto lattice = [&] {
      return Vector(Vector(random.integer(33) - 16, random.integer(33) - 16, random.integer(33) - 16) * unit);
    };
    Ray ray;
    ray.origin = lattice();
    ray.direction = lattice();
    if (i % 3 == 0) {
      ray.direction.setZero();
      ray.direction[random.integer(3)] = random.integer(2) == 0 ? unit : -unit;
    }
    if (ray.direction.isZero(0)) continue;
    if (i % 5 == 0) ray.t_min = -1;
    if (i % 7 == 0) ray.t_max = random.integer(3);
    check_ray(body, ray, counts);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(counts.hits, 3'000);
}

// A closed surface cannot be passed, wherever the ray runs.
TEST(CastRay, NoRayLeavesAClosedSurface) {
  shapes::Random random(14);
  for (const TriangleMesh& mesh : {shapes::sphere(4), shapes::cube(1), shapes::sphere(0)}) {
    const ShapePtr shape = make_shape(mesh);
    for (int i = 0; i < 20'000; ++i) {
      const Motion motion = Motion::resting(random_pose(random, i % 2 == 0 ? 1 : 1e5), random(0.1, 10));
      const std::int64_t t = random.integer(static_cast<int>(mesh.triangles.rows()));
      const Vector from = motion.start * Vector(random.point(0.2) * motion.scale);
      const Vector edge = mesh.corner(t, 0) + (i % 3) * 0.25 * (mesh.corner(t, 1) - mesh.corner(t, 0));
      Ray ray;
      ray.origin = from;
      ray.direction = motion.start * Vector(edge * motion.scale) - from;
      ASSERT_EQ(cast_ray(*shape, motion, ray).answer, RayAnswer::hit);
      ray.direction = -ray.direction;
      ASSERT_EQ(cast_ray(*shape, motion, ray).answer, RayAnswer::hit);
    }
  }
}

std::vector<double> numbers(const RayResult& r) {
  return {double(r.answer), r.hit.t,         double(r.hit.triangle), r.hit.barycentric[0],   r.hit.barycentric[1],
          r.hit.normal[0],  r.hit.normal[1], r.hit.normal[2],        double(r.hit.back_face)};
}

TEST(CastRay, BatchesAnswerLikeSingleCallsOnEveryInstructionSetAndAllocateNothing) {
  const std::vector<PlacedBody> bodies = placed_bodies(15);
  shapes::Random random(16);
  for (const PlacedBody& body : bodies) {
    std::vector<Ray> rays;
    for (int i = 0; i < 60; ++i) rays.push_back(ray_at(body, random, i % 8));
    std::vector<RayResult> results(rays.size());
    const long before = allocations;
    cast_rays(*body.shape, body.motion, rays, results);
    EXPECT_EQ(allocations, before);
    const auto answers = expect_same_on_all_targets([&] {
      std::vector<double> all;
      for (const Ray& ray : rays) {
        const std::vector<double> one = numbers(cast_ray(*body.shape, body.motion, ray));
        all.insert(all.end(), one.begin(), one.end());
      }
      return all;
    });
    std::vector<double> batch;
    for (const RayResult& result : results) {
      const std::vector<double> one = numbers(result);
      batch.insert(batch.end(), one.begin(), one.end());
    }
    EXPECT_EQ(batch, answers) << body.name;
  }
}

TEST(CastRay, AllHitsKeepsTheFirstOnes) {
  shapes::Random random(17);
  for (const PlacedBody& body : placed_bodies(18)) {
    for (int i = 0; i < 50; ++i) {
      const Ray ray = ray_at(body, random, i % 5);
      std::vector<RayHit> all(64), few(2);
      const RayHits of_all = all_hits(*body.shape, body.motion, ray, all);
      const RayHits of_few = all_hits(*body.shape, body.motion, ray, few);
      EXPECT_EQ(of_all.count, of_few.count);
      EXPECT_EQ(all_hits(*body.shape, body.motion, ray, {}).count, of_all.count);
      for (std::int64_t k = 0; k < std::min<std::int64_t>(2, of_all.count); ++k) {
        EXPECT_EQ(all[static_cast<std::size_t>(k)].triangle, few[static_cast<std::size_t>(k)].triangle);
        EXPECT_EQ(all[static_cast<std::size_t>(k)].t, few[static_cast<std::size_t>(k)].t);
      }
      int calls = 0;
      const RayAnswer answer =
          for_each_hit(*body.shape, body.motion, ray, {}, [&](const RayHit&) { return ++calls < 2; });
      EXPECT_EQ(calls, static_cast<int>(std::min<std::int64_t>(2, of_all.count)));
      EXPECT_EQ(answer, of_all.answer);
    }
  }
}

}  // namespace
}  // namespace encage::test
