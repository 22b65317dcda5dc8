// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/separation/plane_check.h"

#include "oracles/body.h"
#include "oracles/sampled.h"

#include <encage/contact.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;

std::vector<Body> plane_bodies() {
  std::vector<Body> all;
  for (const Sample& sample : sample_shapes(0)) {
    all.emplace_back(sample);
    all.emplace_back(without_fine(sample));
    all.emplace_back(without_cages(scaled(sample, -4)));
    Sample far = without_cages(sample);
    far.hierarchy.origin = Vector(1000, -250.25, 0.375);
    all.emplace_back(far);
  }
  return all;
}

/// Heights of a vertex above the plane at both ends.
std::pair<Real, Real> heights(const Body& body, std::int64_t v, const Motion& motion, const HalfSpace& plane) {
  const Point x = (body.origin() + body.mesh().vertex(static_cast<std::int32_t>(v))).cast<Real>();
  const auto height = [&](const Pose& pose) {
    const Point y = pose.linear().cast<Real>() * x + pose.translation().cast<Real>();
    return plane.normal.cast<Real>().dot(y) - static_cast<Real>(plane.offset);
  };
  return {height(motion.start), height(motion.end)};
}

/// The first time at which a height of h0 + (h1 - h0) t is no more than margin + arc 4 t (1 - t); no value if it is not
/// in [0, 1].
std::optional<Real> first_time(Real h0, Real h1, Real margin, Real arc) {
  const Real a = h0 - margin, c = 4 * arc, b = h1 - h0 - c;
  if (a <= 0) return 0;
  const Real discriminant = b * b - 4 * a * c;
  if (b >= 0 || discriminant < 0) return std::nullopt;
  const Real t = 2 * a / (-b + std::sqrt(discriminant));
  return t <= 1 ? std::optional(t) : std::nullopt;
}

struct Scene {
  const Body& body;
  Motion motion;
  HalfSpace plane;
  double margin = 0, arc = 0;
};

Scene random_scene(shapes::Random& random, const std::vector<Body>& all) {
  const Body& body = all[random.integer(static_cast<int>(all.size()))];
  const double size = body.diagonal();
  Pose pose = random_pose(random, 0);
  pose.translation() = random.point(3) - pose.linear() * body.origin();
  Motion motion = random_motion(random, pose, random.integer(3) == 0 ? 3.1 : 0.3, size);
  // The body turns about its local origin.
  motion.end.translation() += motion.start.linear() * body.origin() - motion.end.linear() * body.origin();
  if (random.integer(8) == 0) motion.end = motion.start;
  HalfSpace plane;
  plane.normal = random_direction(random);
  // The lowest vertex starts or ends close to the plane, or anywhere.
  Real low = std::numeric_limits<Real>::infinity();
  for (std::int64_t v = 0; v < body.mesh().vertices.rows(); ++v) {
    const auto [h0, h1] = heights(body, v, motion, plane);
    low = std::min({low, h0, h1});
  }
  plane.offset = static_cast<double>(low) + random(-0.3, 0.3) * size;
  Scene scene{body, motion, plane};
  if (random.integer(2) == 0) scene.margin = random(0, 0.1) * size;
  if (random.integer(3) == 0) scene.arc = random(0, 0.2) * size;
  return scene;
}

TEST(PlaneCheck, AgreesWithEveryVertexInLongDouble) {
  shapes::Random random(1);
  const std::vector<Body> all = plane_bodies();
  int beyond = 0, reaching = 0, below = 0;
  for (int round = 0; round < 20'000; ++round) {
    SCOPED_TRACE(round);
    const Scene s = random_scene(random, all);
    // The check may be off by this distance, which is far above its rounding at 1000 from the origin.
    constexpr double slack = 1e-10;
    Real low = std::numeric_limits<Real>::infinity(), earliest = 2, latest = 2;
    for (std::int64_t v = 0; v < s.body.mesh().vertices.rows(); ++v) {
      const auto [h0, h1] = heights(s.body, v, s.motion, s.plane);
      low = std::min({low, h0, h1});
      earliest = std::min(earliest, first_time(h0, h1, s.margin + slack, s.arc + slack).value_or(2));
      latest = std::min(latest, first_time(h0, h1, s.margin, s.arc).value_or(2));
    }
    const bool said = separated(*s.body.shape, s.motion, s.plane, s.margin).separated;
    if (low <= s.margin) {
      ASSERT_FALSE(said);
    }
    if (low > s.margin + slack) {
      ASSERT_TRUE(said);
    }
    beyond += said;
    below += low < -s.margin;
    if (!s.body.has_fine()) continue;
    const auto found = first_contact(*s.body.shape, s.motion, s.plane, {.margin = s.margin, .arc = s.arc});
    if (latest <= 1) {
      ASSERT_TRUE(found);
    }
    if (earliest > 1) {
      ASSERT_FALSE(found);
    }
    if (!found) continue;
    ++reaching;
    EXPECT_LE(found->time, latest);
    EXPECT_GE(found->time, 0);
    EXPECT_GE(found->time, std::min<Real>(earliest, 1) - 1e-6L);
    EXPECT_EQ(found->kind, ContactKind::vertex_plane);
    EXPECT_EQ(found->normal, s.plane.normal);
    const auto [h0, h1] = heights(s.body, found->vertices[0], s.motion, s.plane);
    const Real t = found->time, height = (1 - t) * h0 + t * h1;
    EXPECT_NEAR(s.plane.normal.dot(found->point) - s.plane.offset, static_cast<double>(height), 1e-9);
    if (t > 0) {
      EXPECT_NEAR(static_cast<double>(height), s.margin + s.arc * 4 * found->time * (1 - found->time), 1e-5);
    }
    EXPECT_EQ(found->vertices[1], -1);
    // An earlier `latest` changes nothing else.
    const auto again =
        first_contact(*s.body.shape, s.motion, s.plane, {.margin = s.margin, .arc = s.arc, .latest = found->time});
    ASSERT_TRUE(again);
    EXPECT_EQ(again->vertices, found->vertices);
    if (found->time > 1e-3) {
      EXPECT_FALSE(first_contact(*s.body.shape, s.motion, s.plane,
                                 {.margin = s.margin, .arc = s.arc, .latest = found->time * 0.999}));
    }
  }
  EXPECT_GT(beyond, 3'000);
  EXPECT_GT(reaching, 3'000);
  EXPECT_GT(below, 3'000);
}

TEST(FirstContact, SaysThatABodyIsInsideTheHalfSpace) {
  const std::vector<Body> all = sample_bodies();
  const Body& box = find(all, "box");  // half 1
  const Body& star = find(all, "star");
  const CompoundPart parts[] = {{star.shape, shift(0, 0, 9)}, {box.shape}};
  const Motion rest = Motion::resting(shift(0, 0, 1));
  for (const ShapePtr& shape : {box.shape, make_compound(parts)}) {
    for (const double offset : {1e-9, 0.5, 5.0}) {
      const auto inside = first_contact(*shape, rest, HalfSpace{.offset = offset});
      ASSERT_TRUE(inside);
      EXPECT_EQ(inside->time, 0);
      EXPECT_TRUE(inside->overlapping);
    }
    const auto touching = first_contact(*shape, rest, HalfSpace{});
    ASSERT_TRUE(touching);
    EXPECT_FALSE(touching->overlapping);
    const auto near = first_contact(*shape, rest, HalfSpace{.offset = -0.1}, {.margin = 0.2});
    ASSERT_TRUE(near);
    EXPECT_FALSE(near->overlapping);
  }
}

TEST(PlaneCheck, TiesGoToTheSmallestVertex) {
  const Body box(without_cages(sample_shapes(0)[1]));
  Motion fall;
  fall.start.translation() = Vector(0, 0, 2);
  const auto found = first_contact(*box.shape, fall, HalfSpace{.offset = -0.5});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->time, 0.75, 1e-6);
  EXPECT_EQ(found->vertices[0], 0);  // the first of the four at the bottom
}

TEST(PlaneCheck, KnownAnswersWithAnArc) {
  const Body box(without_cages(sample_shapes(0)[1]));
  Motion slide;  // parallel to the plane, 0.25 above it
  slide.end.translation().x() = 1;
  const HalfSpace plane{.offset = -1.25};
  const auto ask = [&](double arc) { return first_contact(*box.shape, slide, plane, {.arc = arc}); };
  EXPECT_FALSE(ask(0));
  EXPECT_FALSE(ask(0.2499));
  ASSERT_TRUE(ask(0.25));  // a double root
  EXPECT_NEAR(ask(0.25)->time, 0.5, 1e-6);
  EXPECT_LE(ask(0.25)->time, 0.5);
  ASSERT_TRUE(ask(1.0 / 3));  // 4 t (1 - t) = 3/4
  EXPECT_NEAR(ask(1.0 / 3)->time, 0.25, 1e-6);
  EXPECT_TRUE(separated(*box.shape, slide, plane, 0.2499).separated);
  EXPECT_FALSE(separated(*box.shape, slide, plane, 0.25).separated);
  EXPECT_FALSE(separated(*box.shape, slide, plane, -1).separated);
}

TEST(PlaneCheck, PlanesThatAreNoneProveNothing) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const Body box(without_cages(sample_shapes(0)[1]));
  const Motion rest = Motion::resting(Pose::Identity());
  const auto said = [&](const HalfSpace& plane) {
    const bool contact = first_contact(*box.shape, rest, plane).has_value();
    EXPECT_EQ(separated(*box.shape, rest, plane).separated, !contact);
    return !contact;
  };
  EXPECT_TRUE(said({.offset = -9}));
  EXPECT_TRUE(said({.normal = Vector(0, 0, 1 + 9e-10), .offset = -9}));
  for (const double z : {1 + 1e-8, 1 - 1e-8, 0.5, 0.0, nan, infinity}) {
    EXPECT_FALSE(said({.normal = Vector(0, 0, z), .offset = -9})) << z;
  }
  EXPECT_FALSE(said({.offset = nan}));
  EXPECT_FALSE(said({.offset = infinity}));
  EXPECT_FALSE(said({.offset = -infinity}));
  for (const double bad : {nan, infinity}) {
    EXPECT_FALSE(separated(*box.shape, rest, HalfSpace{.offset = -9}, bad).separated);
    EXPECT_TRUE(first_contact(*box.shape, rest, HalfSpace{.offset = -9}, {.margin = bad}));
    EXPECT_TRUE(first_contact(*box.shape, rest, HalfSpace{.offset = -9}, {.arc = bad}));
  }
  Motion turned = rest;
  turned.end.linear() = Eigen::Vector3d(-1, -1, 1).asDiagonal();
  EXPECT_FALSE(separated(*box.shape, turned, HalfSpace{.offset = -9}).separated);
}

TEST(PlaneCheck, FineErrorCounts) {
  Sample s = without_cages(sample_shapes(0)[1]);
  s.hierarchy.fine_error = 0.01;
  const Body box(s);
  const Motion rest = Motion::resting(Pose::Identity());
  EXPECT_TRUE(separated(*box.shape, rest, HalfSpace{.offset = -1.0101}).separated);
  EXPECT_FALSE(separated(*box.shape, rest, HalfSpace{.offset = -1.0099}).separated);
}

}  // namespace
}  // namespace encage::test
