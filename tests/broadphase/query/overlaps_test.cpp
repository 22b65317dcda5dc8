// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "tests/broadphase/query/ask_body.h"

#include <encage/separated.h>

#include <gtest/gtest.h>

#include <functional>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;

/// A volume as the query takes it, and its surface as a mesh, widened by a radius.
struct Volume {
  std::string kind;
  std::function<bool(const PlacedBody&)> overlaps;
  TriangleMesh mesh;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  double radius = 0;
  Vector inner = Vector::Zero();  ///< a point of it
};

TriangleMesh segment(const Vector& a, const Vector& b) {
  return shapes::mesh({{a[0], a[1], a[2]}, {b[0], b[1], b[2]}}, {{0, 1, 1}});
}

Volume sphere_at(const Vector& p, double radius) {
  const Sphere sphere{p, radius};
  return {"sphere",      [=](const PlacedBody& b) { return overlaps(*b.shape, b.motion, sphere); },
          segment(p, p), Eigen::Isometry3d::Identity(),
          radius,        p};
}

Volume capsule_at(const Vector& a, const Vector& b, double radius) {
  const Capsule capsule{a, b, radius};
  return {"capsule",     [=](const PlacedBody& body) { return overlaps(*body.shape, body.motion, capsule); },
          segment(a, b), Eigen::Isometry3d::Identity(),
          radius,        a};
}

Volume box_at(const Eigen::Isometry3d& pose, const Vector& half) {
  const OrientedBox box{pose, half};
  return {"box",
          [=](const PlacedBody& b) { return overlaps(*b.shape, b.motion, box); },
          shapes::box(-half, half),
          pose,
          0,
          pose.translation()};
}

/// Of four points or fewer; more of them are copies or lie inside.
Volume hull_of(const std::vector<Vector>& corners, double radius) {
  std::vector<Vector> points = corners;
  for (const Vector& p : corners) points.push_back(0.5 * (p + corners[0]));
  std::vector<std::array<double, 3>> v;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector& p = corners[std::min(i, corners.size() - 1)];
    v.push_back({p[0], p[1], p[2]});
  }
  return {"hull of " + std::to_string(corners.size()),
          [=](const PlacedBody& b) { return overlaps(*b.shape, b.motion, points, radius); },
          shapes::mesh(v, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}),
          Eigen::Isometry3d::Identity(),
          radius,
          corners[0]};
}

Volume volume_near(const PlacedBody& body, shapes::Random& random, int i) {
  const double size = body.box.diagonal().norm();
  const auto place = [&] { return Vector(body.box.center() + random(0, 0.9) * size * random_direction(random)); };
  const auto near = [&](const Vector& p, double most) { return Vector(p + random.point(most * size)); };
  const double extent = std::exp(random(-5, -1));
  const Vector p = place();
  switch (i % 6) {
    case 0: {
      // A sphere that just touches, or just does not.
      const auto distance = static_cast<double>(body.distance(p));
      return sphere_at(p, random.integer(2) == 0 ? random(0, 0.3) * size : distance * (1 + random(-1e-9, 1e-9)));
    }
    case 1: return capsule_at(p, near(p, extent), random(0, 0.5) * extent * size);
    case 2: {
      Eigen::Isometry3d pose = random_pose(random, 1);
      pose.translation() = p;
      const Vector half = random.integer(4) == 0
                              ? Vector(extent * size, 0, extent * size)
                              : Vector(size * Vector(random(0, 1), random(0, 1), random(0, 1)) * extent);
      return box_at(pose, half);
    }
    case 3: return hull_of({p, near(p, extent), near(p, extent), near(p, extent)}, 0);
    case 4: return hull_of({p, near(p, extent), near(p, extent)}, random(0, 0.1) * extent * size);
    default: {
      // A tetrahedron that shares a vertex or an edge with the body.
      const RealTriangle& t = body.triangles[static_cast<std::size_t>(random.integer(int(body.triangles.size())))];
      const Vector a = t[0].cast<double>(), b = random.integer(2) == 0 ? Vector(t[1].cast<double>()) : near(a, extent);
      return hull_of({a, b, near(a, extent), near(a, extent)}, 0);
    }
  }
}

/// Exact truth: whether body and volume have a point in common, the volume being widened by `more`.
bool meet(const PlacedBody& body, const Volume& volume, double more) {
  const ExactBody exact(Vector::Zero(), volume.mesh, volume.pose);
  for (std::size_t i = 0; i < body.exact.size(); ++i) {
    if (surfaces_meet(body.exact[i], exact, volume.radius + more)) return true;
    if (body.solid[i] && winding_number(body.exact[i], volume.inner) != 0) return true;
  }
  // A body within the volume.
  if (!is_closed(volume.mesh) || volume.mesh.triangles.rows() < 4) return false;
  return std::any_of(body.exact.begin(), body.exact.end(),
                     [&](const ExactBody& part) { return holds_component(exact, part); });
}

TEST(Overlaps, IsFalseOnlyForVolumesThatExactArithmeticSeesApart) {
  std::vector<PlacedBody> bodies = placed_bodies(31);
  const int count = question_count("ENCAGE_QUERY_VOLUMES", 6'000);
  shapes::Random random(32);
  int touching = 0, apart = 0, undecided = 0;
  for (int i = 0; i < count; ++i) {
    const PlacedBody& body = bodies[static_cast<std::size_t>(random.integer(static_cast<int>(bodies.size())))];
    const Volume volume = volume_near(body, random, i);
    const bool may = volume.overlaps(body);
    if (!may) {
      ASSERT_FALSE(meet(body, volume, 0)) << body.name << ", " << volume.kind;
      ++apart;
      continue;
    }
    ++touching;
    const bool solid = std::all_of(body.solid.begin(), body.solid.end(), [](bool s) { return s; });
    if (!solid) continue;  // unknown interiors
    const double rounding = body.rounding(volume.inner) + 1e-13 * volume.radius;
    if (!meet(body, volume, 8 * rounding)) ++undecided;
  }
  EXPECT_GT(touching, count / 5);
  EXPECT_GT(apart, count / 5);
  EXPECT_LE(undecided, count / 1000) << "apart, but not proven";
}

TEST(Overlaps, SolidsAreSolid) {
  const std::vector<Body> bodies = sample_bodies();
  const auto at = [&](const char* name, const Vector& p, double radius = 0.01) {
    return overlaps(*find(bodies, name).shape, Motion{}, Sphere{p, radius});
  };
  EXPECT_TRUE(at("box", {0, 0, 0}));
  EXPECT_FALSE(at("box", {1.02, 0, 0}));
  EXPECT_TRUE(at("box", {1.01, 0, 0})) << "touches";
  EXPECT_FALSE(at("torus", {0, 0, 0})) << "in the hole";
  EXPECT_TRUE(at("open box", {0, 0, 0})) << "an unknown interior";
  EXPECT_FALSE(at("open box", {0, 0, 5}));
  const Body hollow(find(bodies, "box").sample, 1, true);
  EXPECT_FALSE(overlaps(*hollow.shape, Motion{}, Sphere{{0, 0, 0}, 0.5}));
  EXPECT_TRUE(overlaps(*hollow.shape, Motion{}, Sphere{{0, 0, 0}, 1}));
  EXPECT_TRUE(overlaps(*hollow.shape, Motion{}, OrientedBox{shift(0), {5, 5, 5}})) << "within the volume";
}

TEST(Overlaps, HalfSpacesAreThoseOfSeparated) {
  shapes::Random random(33);
  int apart = 0;
  for (const PlacedBody& body : placed_bodies(34)) {
    for (int i = 0; i < 40; ++i) {
      const Vector n = random_direction(random);
      const double size = body.box.diagonal().norm();
      const HalfSpace plane{n, n.dot(body.box.center()) + random(-1, 1) * size};
      const bool may = overlaps(*body.shape, body.motion, plane);
      EXPECT_EQ(may, !separated(*body.shape, body.motion, plane).separated);
      if (may) continue;
      ++apart;
      for (const ExactBody& part : body.exact) EXPECT_TRUE(all_beyond(part, n, plane.offset, 0));
    }
  }
  EXPECT_GT(apart, 100);
}

// A box whose hull is given with all that a hull may have too much.
TEST(Overlaps, HullsAgreeWithTheBoxesThatTheyAre) {
  shapes::Random random(35);
  const std::vector<PlacedBody> bodies = placed_bodies(36);
  int apart = 0;
  for (int i = 0; i < 2'000; ++i) {
    const PlacedBody& body = bodies[static_cast<std::size_t>(i) % bodies.size()];
    const double size = body.box.diagonal().norm();
    OrientedBox box;
    box.pose = random_pose(random, 1);
    box.pose.translation() = body.box.center() + random(0, 0.9) * size * random_direction(random);
    box.half = size * Vector(random(0, 0.2), random(0, 0.2), random(0, 0.2));
    std::vector<Vector> points;
    for (int k = 0; k < 200; ++k) {
      const Vector x = k < 8 ? Vector((k & 1) ? 1 : -1, (k & 2) ? 1 : -1, (k & 4) ? 1 : -1) : random.point(1);
      points.push_back(box.pose * Vector(x.cwiseProduct(box.half)));
    }
    const bool may = overlaps(*body.shape, body.motion, points);
    EXPECT_EQ(may, overlaps(*body.shape, body.motion, box)) << body.name;
    apart += !may;
  }
  EXPECT_GT(apart, 500);
}

TEST(Overlaps, AllocatesNothing) {
  shapes::Random random(37);
  const std::vector<Vector> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  for (const PlacedBody& body : placed_bodies(38)) {
    const long before = allocations;
    int count = overlaps(*body.shape, body.motion, Sphere{body.box.center(), 1});
    count += overlaps(*body.shape, body.motion, Capsule{{0, 0, 0}, body.box.center(), 1});
    count += overlaps(*body.shape, body.motion, OrientedBox{body.motion.start, {1, 1, 1}});
    count += overlaps(*body.shape, body.motion, points, 0.5);
    EXPECT_EQ(allocations, before) << count;
  }
}

}  // namespace
}  // namespace encage::test
