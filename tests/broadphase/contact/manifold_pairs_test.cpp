// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/exact_pair.h"
#include "oracles/sampled.h"
#include "tests/broadphase/contact/ask_manifold.h"

#include <encage/distance.h>
#include <encage/manifold.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Vector = Eigen::Vector3d;
using Pose = Eigen::Isometry3d;

constexpr double infinity = std::numeric_limits<double>::infinity();

// ---- Against all vertices and all edges -------------------------------------

/// Two bodies that are apart by no more than the margin.
struct Near {
  const Body *a, *b;
  Motion at_a, at_b;
  double gap, margin, size;
};

/// Moves b towards a until the surfaces are `gap` apart; false if they touch, or one is in the other.
bool approach(Near& pair, double gap) {
  for (int i = 0; i < 8; ++i) {
    const DistanceResult found = distance(*pair.a->shape, pair.at_a, *pair.b->shape, pair.at_b);
    if (!(found.lower > 0)) return false;
    pair.gap = found.upper;
    if (found.upper <= 1.001 * gap) return true;
    pair.at_b.start.translation() += (found.point_a - found.point_b) * (1 - gap / found.upper);
    pair.at_b.end = pair.at_b.start;
  }
  return pair.gap <= pair.margin;
}

std::vector<Near> near_pairs(const std::vector<Body>& all, int rounds, std::uint32_t seed) {
  shapes::Random random(seed);
  std::vector<Near> pairs;
  for (int round = 0; round < rounds; ++round) {
    const Body &a = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))],
               &b = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))];
    const double scale_b = round % 4 == 0 ? 0.25 : 1, size = a.diagonal() + scale_b * b.diagonal();
    Near pair{&a, &b,  Motion::resting(random_pose(random, 5)), Motion::resting(random_pose(random, 0), scale_b), 0,
              0,  size};
    pair.at_b.start.translation() = pair.at_a.start.translation() + random_direction(random) * random(0.1, 0.6) * size;
    pair.at_b.end = pair.at_b.start;
    pair.margin = size * std::pow(10, random(-4, -1));
    if (approach(pair, random(0.1, 0.9) * pair.margin)) pairs.push_back(pair);
  }
  return pairs;
}

double distance_to(const Vector& p, const std::vector<RealTriangle>& triangles) {
  Real least = std::numeric_limits<Real>::infinity();
  for (const RealTriangle& t : triangles) least = std::min(least, point_triangle_distance(p.cast<Real>(), t));
  return static_cast<double>(least);
}

TEST(ManifoldPairs, LeastSeparationIsTheDistanceAndPointsLieOnBothSurfaces) {
  const std::vector<Body> all = sample_bodies();
  const std::vector<Near> pairs = near_pairs(all, 40000, 21);
  EXPECT_GT(pairs.size(), 800U);
  for (const Near& pair : pairs) {
    SCOPED_TRACE(testing::Message() << pair.a->sample.name << " and " << pair.b->sample.name << ", gap " << pair.gap
                                    << ", margin " << pair.margin << ", pair " << &pair - pairs.data());
    const Points points =
        contacts(*pair.a->shape, pair.at_a, *pair.b->shape, pair.at_b, {.margin = pair.margin}, pair.size + 10);
    EXPECT_NEAR(least_separation(points), pair.gap, 1e-9 * pair.size);
    const auto on_a = at_time(pair.a->mesh(), pair.a->origin(), pair.at_a, 0),
               on_b = at_time(pair.b->mesh(), pair.b->origin(), pair.at_b, 0);
    for (const ManifoldPoint& p : points) {
      EXPECT_LT(distance_to(p.point_a, on_a), 1e-9 * pair.size);
      EXPECT_LT(distance_to(p.point_b, on_b), 1e-9 * pair.size);
      EXPECT_GE(p.separation, pair.gap - 1e-9 * pair.size);
    }
    if (HasFailure()) break;
  }
}

// What a cache remembers of slow bodies saves work, and changes nothing but which of nearly equal points are chosen.
TEST(ManifoldPairs, MemoryOfSlowBodiesFindsWhatAFreshSearchFinds) {
  const std::vector<Body> all = sample_bodies();
  const std::vector<Near> pairs = near_pairs(all, 3000, 22);
  shapes::Random random(23);
  int compared = 0, with_points = 0;
  for (const Near& pair : pairs) {
    SCOPED_TRACE(testing::Message() << pair.a->sample.name << " and " << pair.b->sample.name << ", pair "
                                    << &pair - pairs.data());
    const double reach = pair.size + 10;
    ManifoldCache cache;
    Motion at_b = pair.at_b;
    const Vector way = random_direction(random);
    for (int step = 0; step < 12; ++step) {
      // To and fro, by a fraction of the margin in each step.
      const double share = step % 8 < 4 ? 0.15 : -0.15;
      at_b.start = at_b.end;
      at_b.start.translation() += share * pair.margin * way;
      at_b.end = at_b.start;
      if (!(distance(*pair.a->shape, pair.at_a, *pair.b->shape, at_b).lower > 1e-9 * pair.size)) break;
      const Points fresh = contacts(*pair.a->shape, pair.at_a, *pair.b->shape, at_b, {.margin = pair.margin}, reach);
      const Points kept =
          contacts(*pair.a->shape, pair.at_a, *pair.b->shape, at_b, {.margin = pair.margin}, cache, reach);
      EXPECT_EQ(kept.empty(), fresh.empty());
      ++compared;
      if (kept.empty() || fresh.empty()) continue;
      ++with_points;
      // The deepest point of the step before stays if it is less deep by a twentieth of the margin.
      EXPECT_NEAR(least_separation(kept), least_separation(fresh), 0.051 * pair.margin + 1e-9 * pair.size);
    }
    if (HasFailure()) break;
  }
  EXPECT_GT(compared, 2000);
  EXPECT_GT(with_points, 1000);
}

/// A mesh in the world with what stands around its vertices and edges.
struct Neighbours {
  struct Edge {
    Vector start, end;
    std::array<Vector, 2> out;  ///< in the plane of each triangle, out of it
    bool convex;
  };
  std::vector<Vector> vertices;
  std::vector<std::vector<Vector>> spokes;  ///< per vertex: unit directions to its neighbours
  std::vector<Vector> vertex_normals;       ///< per vertex: the sum of the normals around it
  std::vector<std::array<Vector, 3>> triangles;
  std::vector<Edge> edges;

  Neighbours(const Body& body, const Motion& at) {
    const TriangleMesh& mesh = body.mesh();
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
      vertices.push_back(at.start * (at.scale * (body.origin() + Vector(mesh.vertices.row(v)))));
    }
    spokes.resize(vertices.size());
    vertex_normals.resize(vertices.size(), Vector::Zero());
    std::map<std::pair<int, int>, Vector> opposite;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      std::array<Vector, 3> corner;
      for (int k = 0; k < 3; ++k) corner[static_cast<std::size_t>(k)] = vertices[mesh.triangles(t, k)];
      triangles.push_back(corner);
      const Vector normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
      for (int k = 0; k < 3; ++k) vertex_normals[mesh.triangles(t, k)] += normal;
      for (int k = 0; k < 3; ++k) {
        const int from = mesh.triangles(t, k), to = mesh.triangles(t, (k + 1) % 3);
        spokes[from].push_back((vertices[to] - vertices[from]).normalized());
        opposite[{from, to}] = vertices[mesh.triangles(t, (k + 2) % 3)];
      }
    }
    for (const auto& [ends, third] : opposite) {
      if (ends.first > ends.second) continue;
      const auto other = opposite.find({ends.second, ends.first});
      if (other == opposite.end()) continue;
      Edge edge{vertices[ends.first], vertices[ends.second], {}, false};
      const Vector along = (edge.end - edge.start).normalized();
      const auto outward = [&](const Vector& apex) -> Vector {
        const Vector in = apex - edge.start;
        return -(in - along.dot(in) * along).normalized();
      };
      edge.out = {outward(third), outward(other->second)};
      const Vector normal = along.cross(-edge.out[0]);  // of the first triangle, which lies to the left
      edge.convex = normal.dot(-edge.out[1]) < -1e-6;
      edges.push_back(edge);
    }
  }

  Vector nearest(const Vector& p) const {
    double least = infinity;
    Vector found = p;
    for (const auto& t : triangles) {
      const Vector q = nearest_in(p, t);
      if ((p - q).squaredNorm() < least) {
        least = (p - q).squaredNorm();
        found = q;
      }
    }
    return found;
  }

 private:
  static Vector nearest_in(const Vector& p, const std::array<Vector, 3>& t) {
    const Vector n = (t[1] - t[0]).cross(t[2] - t[0]);
    bool above = n.squaredNorm() > 0;
    for (std::size_t k = 0; k < 3; ++k) above = above && n.cross(t[(k + 1) % 3] - t[k]).dot(p - t[k]) >= 0;
    if (above) return p - n * (n.dot(p - t[0]) / n.squaredNorm());
    Vector best = t[0];
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector u = t[(k + 1) % 3] - t[k];
      const double s = u.squaredNorm() > 0 ? std::clamp(u.dot(p - t[k]) / u.squaredNorm(), 0.0, 1.0) : 0;
      const Vector q = t[k] + s * u;
      if ((p - q).squaredNorm() < (p - best).squaredNorm()) best = q;
    }
    return best;
  }
};

struct TwinContact {
  Vector point_a, point_b, normal;
  double separation;
};

/// A direction is clearly within a region if it is this far from its border: what lies on a border may go either way.
constexpr double clear = 0.01;

std::vector<TwinContact> brute_force(const Neighbours& a, const Neighbours& b, double margin) {
  std::vector<TwinContact> all;
  const auto add = [&](const Vector& on_a, const Vector& on_b) {
    const Vector apart = on_a - on_b;
    const double separation = apart.norm();
    if (separation > 1e-9 && separation < margin) all.push_back({on_a, on_b, apart / separation, separation});
  };
  const auto stands_out = [](const Neighbours& body, std::size_t v, const Vector& direction) {
    // Corners of cavities stand out into their own wall.
    return body.vertex_normals[v].dot(direction) > 0 &&
           std::all_of(body.spokes[v].begin(), body.spokes[v].end(),
                       [&](const Vector& spoke) { return spoke.dot(direction) < -clear; });
  };
  for (std::size_t v = 0; v < a.vertices.size(); ++v) {
    const Vector near = b.nearest(a.vertices[v]);
    if (stands_out(a, v, (near - a.vertices[v]).normalized())) add(a.vertices[v], near);
  }
  for (std::size_t v = 0; v < b.vertices.size(); ++v) {
    const Vector near = a.nearest(b.vertices[v]);
    if (stands_out(b, v, (near - b.vertices[v]).normalized())) add(near, b.vertices[v]);
  }
  for (const Neighbours::Edge& x : a.edges) {
    for (const Neighbours::Edge& y : b.edges) {
      if (!x.convex || !y.convex) continue;
      const Vector u = x.end - x.start, v = y.end - y.start, w = x.start - y.start;
      const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v), determinant = uu * vv - uv * uv;
      if (determinant < clear * uu * vv) continue;
      const double s = (uv * v.dot(w) - vv * u.dot(w)) / determinant, t = (uu * v.dot(w) - uv * u.dot(w)) / determinant;
      if (std::min({s, t, 1 - s, 1 - t}) < clear) continue;
      const Vector on_a = x.start + s * u, on_b = y.start + t * v, n = (on_a - on_b).normalized();
      if (std::min({x.out[0].dot(-n), x.out[1].dot(-n), y.out[0].dot(n), y.out[1].dot(n)}) > clear) add(on_a, on_b);
    }
  }
  return all;
}

TEST(ManifoldPairs, EveryLeastDistanceOfFeaturesIsReported) {
  std::vector<Body> all;
  for (Body& body : sample_bodies()) {
    if (body.solid() && body.sample.name != "spiked box") all.push_back(std::move(body));
  }
  const std::vector<Near> pairs = near_pairs(all, 10000, 22);
  int count = 0, several = 0;
  std::vector<ManifoldPoint> room(4096);
  for (const Near& pair : pairs) {
    SCOPED_TRACE(testing::Message() << pair.a->sample.name << " and " << pair.b->sample.name << ", gap " << pair.gap
                                    << ", margin " << pair.margin << ", pair " << &pair - pairs.data());
    const Neighbours a(*pair.a, pair.at_a), b(*pair.b, pair.at_b);
    const std::vector<TwinContact> expected = brute_force(a, b, pair.margin);
    ManifoldCache cache;
    const ManifoldOptions options{.margin = pair.margin, .most_points = 4096, .most_per_patch = 4096};
    const auto found = static_cast<std::size_t>(
        contact_manifold(*pair.a->shape, pair.at_a, *pair.b->shape, pair.at_b, options, cache, room));
    const double tolerance = 1e-9 * pair.size;
    for (const TwinContact& twin : expected) {
      EXPECT_TRUE(std::any_of(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(found),
                              [&](const auto& p) {
                                return (p.point_a - twin.point_a).norm() < tolerance &&
                                       (p.point_b - twin.point_b).norm() < tolerance &&
                                       (p.normal - twin.normal).norm() < 1e-6 &&
                                       std::abs(p.separation - twin.separation) < tolerance;
                              }))
          << "separation " << twin.separation << ", normal " << twin.normal.transpose();
    }
    count += static_cast<int>(expected.size());
    several += expected.size() > 1;
    if (HasFailure()) break;
  }
  EXPECT_GT(count, 1000);
  EXPECT_GT(several, 200);
}

TEST(ManifoldPairs, BodiesThatOverlapGetSoundPoints) {
  const std::vector<Body> all = sample_bodies();
  shapes::Random random(24);
  int overlapping = 0;
  for (int round = 0; round < 20000; ++round) {
    const Body &a = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))],
               &b = all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))];
    const double scale = round % 3 == 0 ? 0.2 : 1, size = a.diagonal() + b.diagonal() + 10;
    const Motion at_a = Motion::resting(random_pose(random, 5));
    Motion at_b = Motion::resting(random_pose(random, 0), scale);
    at_b.start.translation() = at_a.start.translation() + random.point(1);
    at_b.end = at_b.start;
    SCOPED_TRACE(testing::Message() << a.sample.name << " and " << b.sample.name << ", round " << round);
    // With memory as well, of a place nearby.
    ManifoldCache cache;
    Points points;
    for (int step = 0; step < 3; ++step) {
      Motion moved = at_b;
      moved.start.translation().z() += 0.01 * (2 - step);
      moved.end = moved.start;
      points = contacts(*a.shape, at_a, *b.shape, moved, {}, cache, size);
    }
    if (!a.solid() || !b.solid() || distance(*a.shape, at_a, *b.shape, at_b).upper > 0) continue;
    ++overlapping;
    EXPECT_FALSE(points.empty());
    EXPECT_LE(least_separation(points), 1e-12 * size);
  }
  EXPECT_GT(overlapping, 1000);
}

// ---- Random pairs against exact arithmetic ------------------------------------------------

TriangleMesh random_body(shapes::Random& random, int kind) {
  switch (kind) {
    case 0: {  // a tetrahedron, oriented outward
      for (;;) {
        std::array<Vector, 4> p;
        for (Vector& v : p) v = random.point(1);
        const double volume = (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]);
        if (volume < 0.1) continue;
        TriangleMesh mesh = shapes::mesh({{}, {}, {}, {}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
        for (int v = 0; v < 4; ++v) mesh.vertices.row(v) = p[static_cast<std::size_t>(v)].transpose();
        return mesh;
      }
    }
    case 1: {
      const Vector half(random(0.1, 1), random(0.1, 1), random(0.1, 1));
      return shapes::box(-half, half);
    }
    case 2: return shapes::box({-1, -1, -0.25}, {1, 1, 0.25});
    case 3: return notched();
    case 4:  // an ellipsoid: convex
    case 5: {
      TriangleMesh mesh = shapes::sphere(kind - 4);
      mesh.vertices = mesh.vertices * Vector(random(0.3, 1), random(0.3, 1), random(0.3, 1)).asDiagonal();
      return mesh;
    }
    case 6: return shapes::torus(0.7, random(0.15, 0.4), 6, 4);
    default: {  // a star
      TriangleMesh mesh = shapes::sphere(1);
      for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) mesh.vertices.row(v) *= random(0.3, 1);
      return mesh;
    }
  }
}

struct SmallBody {
  TriangleMesh mesh;
  ShapePtr shape;
  bool on_lattice;  ///< its coordinates are multiples of an eighth
};

/// A body as make_shape() rounds it.
SmallBody small_body(shapes::Random& random, int kind) {
  TriangleMesh mesh = random_body(random, kind);
  mesh.vertices = mesh.vertices.cast<float>().cast<double>();
  return {mesh, make_shape(mesh), kind == 2 || kind == 3};
}

Pose lattice_pose(shapes::Random& random) {
  Pose pose = Pose::Identity();
  const int axis = random.integer(3), turns = random.integer(4);
  const std::array<double, 4> cosine{1, 0, -1, 0}, sine{0, 1, 0, -1};
  const double c = cosine[static_cast<std::size_t>(turns)], s = sine[static_cast<std::size_t>(turns)];
  const int x = (axis + 1) % 3, y = (axis + 2) % 3;
  pose.linear()(x, x) = pose.linear()(y, y) = c;
  pose.linear()(x, y) = -s;
  pose.linear()(y, x) = s;
  for (int k = 0; k < 3; ++k) pose.translation()[k] = 0.125 * (random.integer(17) - 8);
  return pose;
}

TEST(ManifoldPairs, SurfacesThatMeetHaveAContact) {
  const char* more = std::getenv("ENCAGE_CONTACT_PAIRS");  // longer runs by hand
  const int rounds = more != nullptr ? std::atoi(more) : 100000;
  shapes::Random random(23);
  std::vector<SmallBody> all;
  for (int i = 0; i < 320; ++i) all.push_back(small_body(random, i % 8));
  std::vector<std::size_t> lattice;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].on_lattice) lattice.push_back(i);
  }
  long with_contacts = 0, undecided = 0, apart = 0, missing = 0;
  ManifoldCache cache;
  std::array<ManifoldPoint, 16> room;
  const auto start = std::chrono::steady_clock::now();
  for (int round = 0; round < rounds; ++round) {
    // One pair in five has faces, edges and vertices exactly on each other.
    const bool exact = round % 5 == 0;
    const auto one = [&]() -> const SmallBody& {
      return exact ? all[lattice[static_cast<std::size_t>(random.integer(static_cast<int>(lattice.size())))]]
                   : all[static_cast<std::size_t>(random.integer(static_cast<int>(all.size())))];
    };
    const SmallBody &a = one(), &b = one();
    Pose pose_a = exact ? lattice_pose(random) : random_pose(random, round % 3 == 0 ? 100 : 1),
         pose_b = exact ? lattice_pose(random) : random_pose(random, 0);
    const double scale = exact ? 1 : random(0.3, 1.5);
    if (exact) {
      for (int k = 0; k < 3; ++k) pose_b.translation()[k] += 0.125 * (random.integer(17) - 8);
    } else {
      pose_b.translation() = pose_a.translation() + random_direction(random) * random(0.3, 2.4);
    }
    const double margin = round % 2 == 0 ? 0 : exact ? 0.125 : 1e-3;
    const Motion at_a = Motion::resting(pose_a), at_b = Motion::resting(pose_b, scale);
    cache.clear();
    if (contact_manifold(*a.shape, at_a, *b.shape, at_b, {.margin = margin}, cache, room) > 0) {
      ++with_contacts;
      continue;
    }
    if (separated(*a.shape, at_a, *b.shape, at_b, margin).separated) {
      ++apart;
      continue;
    }
    ++undecided;
    const ExactBody exact_a(Vector::Zero(), a.mesh, pose_a), exact_b(Vector::Zero(), b.mesh, pose_b, scale);
    if (!surfaces_meet(exact_a, exact_b, margin)) continue;
    ++missing;
    ADD_FAILURE() << "round " << round << ", margin " << margin << ", bodies " << &a - all.data() << " and "
                  << &b - all.data() << (exact ? ", on a lattice" : "");
    if (missing == 5) break;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (more != nullptr) {
    std::printf("%d pairs: %ld with contacts, %ld proven apart, %ld asked exactly, %ld missing; %.2f s\n", rounds,
                with_contacts, apart, undecided, missing, seconds);
  }
  EXPECT_GT(with_contacts, rounds / 4);
  EXPECT_GT(apart, rounds / 4);
}

}  // namespace
}  // namespace encage::test
