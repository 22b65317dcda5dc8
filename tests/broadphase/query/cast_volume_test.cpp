// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "tests/broadphase/query/ask_body.h"
#include "tests/broadphase/shape/stored_samples.h"

#include <encage/casts.h>
#include <encage/shape_cache.h>

#include <gtest/gtest.h>

#include <functional>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

/// A volume as casts take it, and the hull that it is: its points, edges and faces, widened by a radius.
struct Caster {
  std::string kind;
  std::function<CastResult(const PlacedBody&, const Vector& way, const CastOptions&)> cast;
  std::function<bool(const PlacedBody&, const Vector& moved)> overlaps;
  std::vector<Vector> points;
  std::vector<std::array<std::int32_t, 3>> faces;  ///< also those that are segments and points
  double radius = 0;
  bool solid = false;  ///< the faces enclose a volume

  Vector middle() const {
    Vector sum = Vector::Zero();
    for (const Vector& p : points) sum += p / static_cast<double>(points.size());
    return sum;
  }
  double norm() const {
    double most = 0;
    for (const Vector& p : points) most = std::max(most, p.norm());
    return most + radius;
  }
};

TriangleMesh soup(const std::vector<Vector>& points, const std::vector<std::array<std::int32_t, 3>>& faces) {
  std::vector<std::array<double, 3>> v;
  for (const Vector& p : points) v.push_back({p[0], p[1], p[2]});
  return shapes::mesh(v, faces);
}

Caster casting_sphere(const Vector& p, double radius) {
  return {"sphere",
          [=](const PlacedBody& b, const Vector& way, const CastOptions& options) {
            return cast(*b.shape, b.motion, Sphere{p, radius}, way, options);
          },
          [=](const PlacedBody& b, const Vector& moved) {
            return overlaps(*b.shape, b.motion, Sphere{p + moved, radius});
          },
          {p},
          {{0, 0, 0}},
          radius};
}

Caster casting_capsule(const Vector& a, const Vector& b, double radius) {
  return {"capsule",
          [=](const PlacedBody& body, const Vector& way, const CastOptions& options) {
            return cast(*body.shape, body.motion, Capsule{a, b, radius}, way, options);
          },
          [=](const PlacedBody& body, const Vector& moved) {
            return overlaps(*body.shape, body.motion, Capsule{a + moved, b + moved, radius});
          },
          {a, b},
          {{0, 1, 1}},
          radius};
}

Caster casting_box(const Eigen::Isometry3d& pose, const Vector& half) {
  const OrientedBox box{pose, half};
  Caster caster{"box",
                [=](const PlacedBody& b, const Vector& way, const CastOptions& options) {
                  return cast(*b.shape, b.motion, box, way, options);
                },
                [=](const PlacedBody& b, const Vector& moved) {
                  OrientedBox there = box;
                  there.pose.translation() += moved;
                  return overlaps(*b.shape, b.motion, there);
                },
                {},
                {},
                0,
                half.minCoeff() > 0};
  const TriangleMesh mesh = shapes::box(-half, half);
  for (std::int32_t v = 0; v < 8; ++v) caster.points.push_back(pose * mesh.vertex(v));
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    caster.faces.push_back({mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)});
  }
  return caster;
}

/// Of three or four points.
Caster casting_hull(const std::vector<Vector>& corners, double radius) {
  std::vector<Vector> points = corners;
  for (const Vector& p : corners) points.push_back(0.5 * (p + corners[0]));
  Caster caster{"hull of " + std::to_string(corners.size()),
                [=](const PlacedBody& b, const Vector& way, const CastOptions& options) {
                  return cast(*b.shape, b.motion, points, radius, way, options);
                },
                [=](const PlacedBody& b, const Vector& moved) {
                  std::vector<Vector> there = points;
                  for (Vector& p : there) p += moved;
                  return overlaps(*b.shape, b.motion, there, radius);
                },
                corners,
                {{0, 2, 1}},
                radius,
                corners.size() == 4};
  if (corners.size() == 4) caster.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return caster;
}

Caster random_caster(const PlacedBody& body, shapes::Random& random, const Vector& p, int i) {
  const double size = body.box.diagonal().norm();
  const double extent = std::exp(random(-5, -1)) * size;
  const auto near = [&] { return Vector(p + random.point(extent)); };
  switch (i % 6) {
    case 0: return casting_sphere(p, random.integer(8) == 0 ? 0 : random(0, 0.5) * extent);
    case 1: return casting_capsule(p, random.integer(8) == 0 ? p : near(), random(0, 0.5) * extent);
    case 2: {
      Eigen::Isometry3d pose = random.integer(3) == 0 ? Eigen::Isometry3d::Identity() : random_pose(random, 1);
      pose.translation() = p;
      return casting_box(pose, random.integer(4) == 0 ? Vector(extent, 0, extent)
                                                      : Vector(extent * Vector(random(0, 1), random(0, 1), 0.5)));
    }
    case 3: return casting_hull({p, near(), near(), near()}, 0);
    case 4: return casting_hull({p, near(), near()}, random(0, 0.1) * extent);
    default: return casting_hull({p, near(), near(), near()}, random(0, 0.1) * extent);
  }
}

struct Case {
  Caster caster;
  Vector way;
};

/// Casts at places of the body, along its faces and edges, past its vertices, from a touch, by nothing, and by far.
Case random_case(const PlacedBody& body, shapes::Random& random, int i) {
  const double size = body.box.diagonal().norm();
  const RealTriangle& t = body.triangles[static_cast<std::size_t>(random.integer(int(body.triangles.size())))];
  const Vector a = t[0].cast<double>(), b = t[1].cast<double>(), c = t[2].cast<double>();
  const auto place = [&] { return Vector(body.box.center() + random(0.3, 1) * size * random_direction(random)); };
  switch (random.integer(8)) {
    case 0: {  // past a vertex, at the distance of the radius
      const double radius = random(0, 0.1) * size;
      const Vector n = random_direction(random), along = n.cross(random_direction(random)).normalized();
      return {casting_sphere(a + n * radius * (1 + random(-1e-9, 1e-9)) - random(0.2, 1) * size * along, radius),
              2 * size * along};
    }
    case 1: {  // along a face, in touch with it or a little away
      const Vector n = (b - a).cross(c - a).stableNormalized();
      const double radius = random(0, 0.05) * size, away = random.integer(2) == 0 ? 0 : 1e-7 * size;
      const Vector along = random.integer(2) == 0 ? Vector(b - a) : Vector(random(-1, 1) * (b - a) + c - a);
      return {casting_sphere(a + (radius + away) * n - random(0, 2) * along, radius), 4 * along};
    }
    case 2: {  // a tetrahedron that begins at a vertex or on an edge
      const Vector p = random.integer(2) == 0 ? a : Vector(0.5 * (a + b));
      const auto near = [&] { return Vector(p + random.point(0.1 * size)); };
      return {casting_hull({p, near(), near(), near()}, 0), random(0, 1) * size * random_direction(random)};
    }
    case 3: return {random_caster(body, random, place(), i), Vector::Zero()};
    case 4: {  // from far
      const Vector from = body.box.center() + 1e4 * size * random_direction(random);
      return {random_caster(body, random, from, i), 2 * (a - from)};
    }
    default: {
      const Vector from = place();
      const Vector target = random.integer(2) == 0 ? a : Vector(body.box.center() + 0.4 * random.point(size));
      return {random_caster(body, random, from, i), random(0.5, 2) * (target - from)};
    }
  }
}

/// Exact truth: whether the body and the space that the hull sweeps on `way` have a point in common.
bool sweeps(const PlacedBody& body, const Caster& caster, const Vector& way) {
  // The ends of the way, and what the edges sweep.
  std::vector<Vector> points = caster.points;
  const auto count = static_cast<std::int32_t>(points.size());
  for (std::int32_t i = 0; i < count; ++i) points.push_back(caster.points[static_cast<std::size_t>(i)] + way);
  std::vector<std::array<std::int32_t, 3>> faces = caster.faces;
  for (const auto& f : caster.faces) {
    faces.push_back({f[0] + count, f[1] + count, f[2] + count});
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t p = f[k], q = f[(k + 1) % 3];
      if (p > q) continue;
      faces.push_back({p, q, q + count});
      faces.push_back({p, q + count, p + count});
    }
  }
  const ExactBody swept(Vector::Zero(), soup(points, faces), Eigen::Isometry3d::Identity());
  const ExactBody start(Vector::Zero(), soup(caster.points, caster.faces), Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < body.exact.size(); ++i) {
    if (surfaces_meet(body.exact[i], swept, caster.radius)) return true;
    if (body.solid[i] && winding_number(body.exact[i], caster.middle()) != 0) return true;
  }
  if (!caster.solid) return false;
  // Triangles that lie within the swept space: their corners were met by a face, or were inside at the start.
  const std::size_t stride = 1 + body.triangles.size() / 30;
  for (std::size_t t = 0; t < body.triangles.size(); t += stride) {
    const Vector corner = body.triangles[t][0].cast<double>();
    if (winding_number(start, corner) != 0) return true;
    if (way.isZero(0)) continue;
    for (std::int64_t f = 0; f < static_cast<std::int64_t>(caster.faces.size()); ++f) {
      if (ray_meets(start, f, {corner, -way, 0, 1})) return true;
    }
  }
  return false;
}

/// Checks a hit, in long double. Counts those whose volume is farther from the triangle than rounding admits, and
/// points that are not where they touch.
void check_hit(const PlacedBody& body, const Caster& caster, const Vector& way, const CastResult& found, int& early,
               int& misplaced) {
  const double rounding = 1e-13 * (body.motion.start.translation().norm() + body.reach + caster.norm() + way.norm());
  const RealTriangle& triangle = body.triangles[static_cast<std::size_t>(found.triangle)];
  const Point moved = (static_cast<Real>(found.time) * way.cast<Real>()).eval();
  const auto corner = [&](std::int32_t v) {
    return Point(caster.points[static_cast<std::size_t>(v)].cast<Real>() + moved);
  };
  Real least = std::numeric_limits<Real>::infinity(), to_point = least;
  for (const auto& f : caster.faces) {
    const RealTriangle face = {corner(f[0]), corner(f[1]), corner(f[2])};
    least = std::min(least, triangle_distance(face, triangle));
    to_point = std::min(to_point, point_triangle_distance(found.point.cast<Real>(), face));
  }
  EXPECT_NEAR(found.normal.norm(), 1, 1e-12);
  EXPECT_LE(point_triangle_distance(found.point.cast<Real>(), triangle), rounding) << caster.kind;
  // The normal parts them: it is the axis along which they are as far apart as the radius.
  Real low = std::numeric_limits<Real>::infinity(), high = -low;
  const Point n = found.normal.cast<Real>();
  for (const Vector& p : caster.points) low = std::min(low, n.dot(p.cast<Real>() + moved));
  for (const Point& p : triangle) high = std::max(high, n.dot(p));
  EXPECT_GE(low - high, caster.radius - rounding) << caster.kind;
  early += least > caster.radius + rounding;
  misplaced += to_point > caster.radius + 8 * rounding;
}

TEST(CastVolume, NoContactIsEarlierInExactArithmetic) {
  const std::vector<PlacedBody> bodies = placed_bodies(51);
  const int count = question_count("ENCAGE_QUERY_CASTS", 1'500);
  shapes::Random random(52);
  int hits = 0, misses = 0, overlapping = 0, unknown = 0, early = 0, misplaced = 0, undecided = 0;
  for (int i = 0; i < count; ++i) {
    const PlacedBody& body = bodies[static_cast<std::size_t>(random.integer(static_cast<int>(bodies.size())))];
    const Case asked = random_case(body, random, i);
    const Caster& caster = asked.caster;
    const Vector& way = asked.way;
    const CastResult found = caster.cast(body, way, {});
    SCOPED_TRACE(body.name + ", " + caster.kind + ", " + std::to_string(i));
    const auto at = [&](double time) { return Vector(time * way); };
    if (found.answer == CastAnswer::overlapping) {
      EXPECT_EQ(found.time, 0);
      ++overlapping;
      const double rounding =
          1e-13 * (body.motion.start.translation().norm() + body.reach + caster.norm() + way.norm());
      Caster wider = caster;
      wider.radius += 8 * rounding;
      if (!sweeps(body, wider, Vector::Zero())) ++undecided;
      continue;
    }
    // No contact before the time of the answer. A hit at time 0 begins in touch.
    ASSERT_LE(0, found.time);
    ASSERT_LE(found.time, 1);
    if (found.time > 0 || found.answer == CastAnswer::miss) {
      ASSERT_FALSE(sweeps(body, caster, at(found.time)));
      for (int k = 0; k < 8; ++k) ASSERT_FALSE(caster.overlaps(body, at(found.time * k / 8)));
    }
    switch (found.answer) {
      case CastAnswer::miss:
        EXPECT_EQ(found.time, 1);
        EXPECT_FALSE(caster.overlaps(body, way));
        ++misses;
        break;
      case CastAnswer::hit:
        ASSERT_GE(found.triangle, 0);
        check_hit(body, caster, way, found, early, misplaced);
        ++hits;
        break;
      default: {
        ++unknown;
        EXPECT_FALSE(std::all_of(body.solid.begin(), body.solid.end(), [](bool s) { return s; }));
        const CastResult surface = caster.cast(body, way, {.solid = false});
        EXPECT_NE(surface.answer, CastAnswer::unknown);
        EXPECT_GE(surface.time + 1e-9, surface.answer == CastAnswer::overlapping ? 0 : found.time);
      }
    }
  }
  EXPECT_GT(hits, count / 5);
  EXPECT_GT(misses, count / 5);
  EXPECT_GT(overlapping, count / 50);
  EXPECT_GT(unknown, count / 50);
  EXPECT_LE(early, count / 1000) << "hits that no triangle explains";
  EXPECT_LE(misplaced, count / 500) << "points that are elsewhere on a thin triangle";
  EXPECT_LE(undecided, count / 1000) << "apart at the start, but not proven";
}

// Faces in one plane, edges that meet, volumes that slide along faces and just pass corners: all exactly.
TEST(CastVolume, LatticeVolumesMeetFacesEdgesAndVertices) {
  std::vector<PlacedBody> bodies;
  for (const Body& body : query_bodies()) {
    PlacedBody at = placed(body, Motion{});
    if (body.origin().isZero(0) && at.solid[0] && body.diagonal() < 100) bodies.push_back(std::move(at));
  }
  shapes::Random random(58);
  int hits = 0, misses = 0, overlapping = 0, early = 0, misplaced = 0;
  for (int i = 0; i < question_count("ENCAGE_LATTICE_CASTS", 1'000); ++i) {
    const PlacedBody& body = bodies[static_cast<std::size_t>(random.integer(static_cast<int>(bodies.size())))];
    const auto lattice = [&](int most) {
      Vector point;
      for (double& x : point) x = random.integer(2 * most + 1) - most;
      return point;
    };
    const Vector at = 0.5 * lattice(5), half = 0.5 * lattice(2).cwiseAbs();
    const Vector way = random.integer(2) == 0 ? Vector(8 * Vector::Unit(random.integer(3))) : lattice(6);
    Caster caster = casting_box(shift(at[0], at[1], at[2]), half);
    if (i % 3 == 0) caster = casting_sphere(at, half[0]);
    if (i % 3 == 1) caster = casting_capsule(at, at + half, 0.25);
    const CastResult found = caster.cast(body, way, {});
    SCOPED_TRACE(body.name + ", " + caster.kind + ", " + std::to_string(i));
    if (found.answer == CastAnswer::overlapping) {
      EXPECT_TRUE(sweeps(body, caster, Vector::Zero()));
      ++overlapping;
      continue;
    }
    if (found.time > 0 || found.answer == CastAnswer::miss) {
      EXPECT_FALSE(sweeps(body, caster, found.time * way));
    }
    if (found.answer == CastAnswer::hit) {
      EXPECT_TRUE(sweeps(body, caster, way));
      check_hit(body, caster, way, found, early, misplaced);
      ++hits;
    } else {
      EXPECT_EQ(found.answer, CastAnswer::miss);
      ++misses;
    }
  }
  EXPECT_GT(hits, 60);
  EXPECT_GT(misses, 60);
  EXPECT_GT(overlapping, 60);
  EXPECT_EQ(early, 0);
  EXPECT_EQ(misplaced, 0);
}

TEST(CastVolume, TellsTimePointAndNormal) {
  const ShapePtr box = find(sample_bodies(), "box").shape;
  const auto expect = [&](const CastResult& found, double time, const Vector& point, const Vector& normal) {
    ASSERT_EQ(found.answer, CastAnswer::hit);
    EXPECT_NEAR(found.time, time, 1e-12);
    EXPECT_LE((found.normal - normal).norm(), 1e-9);
    EXPECT_LE(std::abs(normal.dot(found.point - point)), 1e-12);
  };
  const Vector down(0, 0, -10), x(1, 0, 0), z(0, 0, 1);
  const CastResult sphere = cast(*box, Motion{}, Sphere{{0.25, 0.5, 5}, 1}, down);
  expect(sphere, 0.3, {0.25, 0.5, 1}, z);
  EXPECT_LE((sphere.point - Vector(0.25, 0.5, 1)).norm(), 1e-12);
  // Beside an edge: at a height of 0.8, with a normal to the side.
  expect(cast(*box, Motion{}, Sphere{{1.6, 0.3, 6}, 1}, down), 0.42, {1, 0.3, 1}, {0.6, 0, 0.8});
  EXPECT_EQ(cast(*box, Motion{}, Sphere{{2.01, 0, 5}, 1}, down).answer, CastAnswer::miss);
  expect(cast(*box, Motion{}, Capsule{{0, 0, 5}, {0.5, 0, 7}, 0.5}, down), 0.35, {0, 0, 1}, z);
  expect(cast(*box, Motion{}, OrientedBox{shift(0.5, 0.5, 5), {1, 1, 1}}, down), 0.3, {0, 0, 1}, z);
  expect(cast(*box, Motion{}, OrientedBox{shift(-5), {1, 1, 1}}, 6 * x), 0.5, {-1, 0, 0}, -x);
  const std::vector<Vector> point = {{-5, 0.1, 0.2}};
  expect(cast(*box, Motion{}, point, 0, 8 * x), 0.5, {-1, 0.1, 0.2}, -x);
  // At the end of the way, and not beyond it.
  EXPECT_EQ(cast(*box, Motion{}, Sphere{{0, 0, 5}, 1}, {0, 0, -3}).answer, CastAnswer::hit);
  EXPECT_EQ(cast(*box, Motion{}, Sphere{{0, 0, 5}, 1}, {0, 0, -2.999}).answer, CastAnswer::miss);
}

TEST(CastVolume, SaysWhatItKnowsAtTheStart) {
  const std::vector<Body> bodies = sample_bodies();
  const auto ask = [&](const char* name, const Vector& p, const Vector& way, bool solid = true) {
    return cast(*find(bodies, name).shape, Motion{}, Sphere{p, 0.25}, way, {.solid = solid});
  };
  EXPECT_EQ(ask("box", {0, 0, 0}, {0, 0, 9}).answer, CastAnswer::overlapping) << "inside";
  EXPECT_EQ(ask("box", {0, 0, 1.2}, {0, 0, 9}).answer, CastAnswer::overlapping) << "across the surface";
  const CastResult within = ask("box", {0, 0, 0}, {0, 0, 9}, false);
  ASSERT_EQ(within.answer, CastAnswer::hit);
  EXPECT_NEAR(within.time, 0.75 / 9, 1e-12);
  EXPECT_NEAR(within.normal.z(), -1, 1e-12);
  EXPECT_EQ(ask("torus", {0, 0, 0}, {0, 0, 0}).answer, CastAnswer::miss) << "in the hole";
  // In touch, moving away, along the face, towards it, and not at all.
  for (const Vector& way : {Vector(0, 0, 1), Vector(1, 0, 0), Vector(0, 0, -1), Vector(0, 0, 0)}) {
    const CastResult touch = ask("box", {0, 0, 1.25}, way);
    ASSERT_EQ(touch.answer, CastAnswer::hit);
    EXPECT_EQ(touch.time, 0);
    EXPECT_NEAR(touch.normal.z(), 1, 1e-9);
  }
  const CastResult resting =
      cast(*find(bodies, "box").shape, Motion{}, OrientedBox{shift(0.3, 0.2, 2), {1, 1, 1}}, {1, 0, 0});
  EXPECT_EQ(resting.answer, CastAnswer::hit);
  EXPECT_EQ(resting.time, 0);
  EXPECT_NEAR(resting.normal.z(), 1, 1e-9);
  // An unknown interior.
  EXPECT_EQ(ask("open box", {0, 0, 0}, {0, 0, 0}).answer, CastAnswer::unknown);
  const CastResult open = ask("open box", {5.25, 0, 0}, {-8, 0, 0}),
                   surface = ask("open box", {5.25, 0, 0}, {-8, 0, 0}, false);
  EXPECT_EQ(open.answer, CastAnswer::unknown);
  EXPECT_NEAR(open.time, 0.5, 1e-6) << "boxes are kept in float";
  EXPECT_EQ(surface.answer, CastAnswer::hit);
  EXPECT_GE(surface.time, open.time);
  EXPECT_EQ(ask("open box", {5.25, 0, 0}, {8, 0, 0}).answer, CastAnswer::miss);
  const Body hollow(find(bodies, "box").sample, 1, true);
  EXPECT_EQ(cast(*hollow.shape, Motion{}, Sphere{{0, 0, 0}, 0.5}, {0, 0, 0.4}).answer, CastAnswer::miss);
  EXPECT_EQ(cast(*hollow.shape, Motion{}, Sphere{{0, 0, 0}, 0.5}, {0, 0, 0.6}).answer, CastAnswer::hit);
}

TEST(CastVolume, HullsAgreeWithTheBoxesThatTheyAre) {
  shapes::Random random(53);
  const std::vector<PlacedBody> bodies = placed_bodies(54);
  int hits = 0, far = 0;
  for (int i = 0; i < 1'000; ++i) {
    const PlacedBody& body = bodies[static_cast<std::size_t>(i) % bodies.size()];
    const double size = body.box.diagonal().norm();
    OrientedBox box;
    box.pose = random_pose(random, 1);
    box.pose.translation() = body.box.center() + size * random_direction(random);
    box.half = size * Vector(random(0, 0.2), random(0, 0.2), random(0, 0.2));
    std::vector<Vector> points;
    for (int k = 0; k < 50; ++k) {
      const Vector x = k < 8 ? Vector((k & 1) ? 1 : -1, (k & 2) ? 1 : -1, (k & 4) ? 1 : -1) : random.point(1);
      points.push_back(box.pose * Vector(x.cwiseProduct(box.half)));
    }
    const Vector way = body.box.center() + 0.3 * random.point(size) - box.pose.translation();
    const CastResult one = cast(*body.shape, body.motion, box, way, {.solid = false});
    const CastResult other = cast(*body.shape, body.motion, points, 0, way, {.solid = false});
    EXPECT_EQ(one.answer, other.answer) << body.name;
    far += std::abs(one.time - other.time) > 1e-9;
    hits += one.answer == CastAnswer::hit;
  }
  EXPECT_LE(far, 1);
  EXPECT_GT(hits, 300);
}

TEST(CastVolume, WhatIsNoVolumeOrNoWayIsUnknown) {
  const ShapePtr box = find(sample_bodies(), "box").shape;
  const double not_a_number = std::numeric_limits<double>::quiet_NaN(),
               boundless = std::numeric_limits<double>::infinity();
  const Vector far(10, 0, 0), way(0, 0, 1);
  const auto expect_unknown = [](const CastResult& found) {
    EXPECT_EQ(found.answer, CastAnswer::unknown);
    EXPECT_EQ(found.time, 0);
  };
  EXPECT_EQ(cast(*box, Motion{}, Sphere{far, 1}, way).answer, CastAnswer::miss);
  for (const double radius : {-1.0, not_a_number, boundless, 1e151}) {
    expect_unknown(cast(*box, Motion{}, Sphere{far, radius}, way));
    expect_unknown(cast(*box, Motion{}, Capsule{far, far, radius}, way));
    expect_unknown(cast(*box, Motion{}, OrientedBox{shift(10), {1, 1, radius}}, way));
    expect_unknown(cast(*box, Motion{}, std::vector<Vector>{far}, radius, way));
  }
  for (const double x : {not_a_number, boundless, 1e151}) {
    expect_unknown(cast(*box, Motion{}, Sphere{{x, 0, 0}, 1}, way));
    expect_unknown(cast(*box, Motion{}, Sphere{far, 1}, {0, 0, x}));
  }
  OrientedBox mirrored{shift(10), {1, 1, 1}};
  mirrored.pose.linear()(0, 0) = -1;
  expect_unknown(cast(*box, Motion{}, mirrored, way));
  Motion skew;
  skew.start.linear()(0, 1) = 0.1;
  expect_unknown(cast(*box, skew, Sphere{far, 1}, way));
  EXPECT_EQ(cast(*box, Motion{}, std::vector<Vector>{}, 1, way).answer, CastAnswer::miss);
  EXPECT_EQ(cast(*box, Motion{}, std::vector<Vector>{far, far, far}, 0, {-20, 0, 0}).answer, CastAnswer::hit);
  // As far and as large as volumes may be, and as short as ways may be.
  EXPECT_EQ(cast(*box, Motion{}, Sphere{{1e150, 0, 0}, 1}, {0, 0, 1e150}).answer, CastAnswer::miss);
  EXPECT_NE(cast(*box, Motion{}, Sphere{{1e150, 0, 0}, 1}, {-1e150, 0, 0}).answer, CastAnswer::miss);
  EXPECT_NE(cast(*box, Motion{}, Sphere{{1e150, 0, 0}, 1e150}, {0, 0, 1}).answer, CastAnswer::miss);
  EXPECT_EQ(cast(*box, Motion{}, Sphere{far, 1}, {-1e-320, 0, 0}).answer, CastAnswer::miss);
  EXPECT_NEAR(cast(*box, Motion{}, Sphere{{1e9, 0, 0}, 1}, {-2e9, 0, 0}).time, 0.5, 1e-8);
}

TEST(CastVolume, CagesAnswerWithoutAFineMesh) {
  shapes::Random random(55);
  int misses = 0, unknown = 0;
  for (const Sample& sample : sample_shapes(0)) {
    if (sample.hierarchy.levels.empty() || sample.hierarchy.fine.triangles.rows() == 0) continue;
    SCOPED_TRACE(sample.name);
    const ShapePtr cages = make_shape(without_fine(sample).hierarchy);
    const Body whole(sample);
    for (int i = 0; i < 100; ++i) {
      const Sphere sphere{random.point(3), 0.1};
      const Vector way = random.point(4);
      const CastResult found = cast(*cages, Motion{}, sphere, way);
      const CastResult truth = cast(*whole.shape, Motion{}, sphere, way, {.solid = whole.solid()});
      ASSERT_TRUE(found.answer == CastAnswer::miss || found.answer == CastAnswer::unknown);
      EXPECT_LE(found.time, truth.time);
      if (found.answer == CastAnswer::miss) {
        EXPECT_EQ(truth.answer, CastAnswer::miss);
        ++misses;
      } else {
        ++unknown;
      }
    }
  }
  EXPECT_GT(misses, 100);
  EXPECT_GT(unknown, 100);
}

TEST(CastVolume, ShapesOfACacheAnswerLikeOthers) {
  const StoredSamples stored;
  ShapeCache cache({.budget_bytes = stored.room_for_a_pair(), .mode = LoadMode::copy});
  shapes::Random random(56);
  std::vector<ShapePtr> cached, loaded;
  for (const auto& file : stored.files) {
    cached.push_back(cache.load(file));
    loaded.push_back(load_shape(file));
  }
  for (int i = 0; i < 200; ++i) {
    const auto k = static_cast<std::size_t>(random.integer(static_cast<int>(cached.size())));
    const Sphere sphere{random.point(2), 0.2};
    const Vector way = random.point(4);
    const CastResult a = cast(*cached[k], Motion{}, sphere, way), b = cast(*loaded[k], Motion{}, sphere, way);
    EXPECT_EQ(a.answer, b.answer);
    EXPECT_EQ(a.triangle >= 0, b.triangle >= 0) << "which one, depends on sizes that are known where triangles tie";
    EXPECT_NEAR(a.time, b.time, 1e-12);
  }
  ShapeCache damaged({.budget_bytes = std::int64_t{1} << 40, .mode = LoadMode::copy});
  const ShapePtr shape = damaged.load(stored.files[0]);
  std::filesystem::resize_file(stored.files[0], std::filesystem::file_size(stored.files[0]) / 2);
  EXPECT_EQ(cast(*shape, Motion{}, Sphere{{5, 0, 0}, 1}, {0, 0, 0}).answer, CastAnswer::miss);
  EXPECT_EQ(cast(*shape, Motion{}, Sphere{{5, 0, 0}, 1}, {-9, 0, 0}).answer, CastAnswer::unknown);
}

TEST(CastVolume, AllocatesNothing) {
  const std::vector<Vector> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  for (const PlacedBody& body : placed_bodies(57)) {
    const Vector way(1, 2, 3);
    const long before = allocations;
    double sum = cast(*body.shape, body.motion, Sphere{body.box.max(), 1}, -way).time;
    sum += cast(*body.shape, body.motion, Capsule{{0, 0, 0}, body.box.center(), 1}, way).time;
    sum += cast(*body.shape, body.motion, OrientedBox{body.motion.start, {1, 1, 1}}, way).time;
    sum += cast(*body.shape, body.motion, points, 0.5, way).time;
    EXPECT_EQ(allocations, before) << sum;
  }
}

}  // namespace
}  // namespace encage::test
