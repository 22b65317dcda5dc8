// SPDX-License-Identifier: GPL-3.0-or-later
// separated() of moving bodies: what it rejects is held against exact times of first contact.
#include "tests/broadphase/exact_pair.h"
#include "tests/broadphase/exact_sweep.h"
#include "tests/broadphase/sampled.h"
#include "tests/broadphase/twin_bodies.h"

#include <encage/broadphase.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

/// Two bodies during a step.
struct Scene {
  const Body& a;
  const Body& b;
  Motion motion_a, motion_b;
  double margin = 0;

  double size() const { return (a.diagonal() + b.diagonal()) / 2; }
  Verdict ask(double more = 0) const { return separated(*a.shape, motion_a, *b.shape, motion_b, margin + more); }
};

/// Moves the whole motion so that the body's centre starts at `where`.
void place(const Body& body, Motion& motion, const Vector& where) {
  const Vector by = where - body.centre(motion.start);
  motion.start.translation() += by;
  motion.end.translation() += by;
}

// ---- The truth.

double speed(const MovingMesh& mesh) { return (mesh.end - mesh.start).rowwise().norm().maxCoeff(); }

MovingMesh one_triangle(const MovingMesh& mesh, std::int64_t t) {
  MovingMesh one{Vertices(3, 3), Vertices(3, 3), Triangles(1, 3)};
  for (int k = 0; k < 3; ++k) {
    one.start.row(k) = mesh.start.row(mesh.triangles(t, k));
    one.end.row(k) = mesh.end.row(mesh.triangles(t, k));
    one.triangles(0, k) = k;
  }
  return one;
}

RealTriangle at_time(const MovingMesh& one, Real t) {
  RealTriangle triangle;
  for (int k = 0; k < 3; ++k) {
    triangle[k] = (1 - t) * one.start.row(k).transpose().cast<Real>() + t * one.end.row(k).transpose().cast<Real>();
  }
  return triangle;
}

/// Whether surfaces that never touch come as close as `distance` > 0. True only if they do. Seen for certain if they
/// come closer by 2^-13 of the way they go; of small bodies also what a search for the least distance of triangles
/// finds.
bool reach(const MovingMesh& a, const MovingMesh& b, double distance) {
  constexpr double coarse = 0x1p-11, fine = 0x1p-14;
  if (!come_within(a, b, distance, coarse)) return false;
  const double certain = distance - 2 * fine * (speed(a) + speed(b));
  if (certain > 0 && come_within(a, b, certain, fine)) return true;
  if (a.triangles.rows() * b.triangles.rows() > 64 * 64) return false;
  for (const auto& [i, j] : close_triangles(a, b, distance)) {
    const MovingMesh p = one_triangle(a, i), q = one_triangle(b, j);
    if (!come_within(p, q, distance, fine)) continue;
    const auto at = [&](Real t) { return triangle_distance(at_time(p, t), at_time(q, t)); };
    if (least_value(at) <= distance) return true;
  }
  return false;
}

bool contained_at_start(const Scene& scene) {
  const auto [a, b, motion_a, motion_b, margin] = scene;
  if (!a.solid() && !b.solid()) return false;
  const ExactBody exact_a(a.origin(), a.sample.source, motion_a.start);
  const ExactBody exact_b(b.origin(), b.sample.source, motion_b.start);
  return (a.solid() && holds_component(exact_a, exact_b)) || (b.solid() && holds_component(exact_b, exact_a));
}

enum class Truth { apart, within_margin, contact, contained };

/// The places of vertices are rounded; what separated() rejects is farther apart than that.
class Twin {
 public:
  explicit Twin(const Scene& scene)
      : scene_(scene),
        a_(moving_mesh(scene.a.origin(), scene.a.sample.source, scene.motion_a)),
        b_(moving_mesh(scene.b.origin(), scene.b.sample.source, scene.motion_b)) {}

  Truth truth() const {
    const Truth truth = touch();
    if (truth != Truth::apart) return truth;
    return scene_.margin > 0 && reach(a_, b_, scene_.margin) ? Truth::within_margin : Truth::apart;
  }

  /// The same for a margin of 0.
  Truth touch() const {
    if (exact_contact(a_, b_)) return Truth::contact;
    return contained_at_start(scene_) ? Truth::contained : Truth::apart;
  }

  /// Proven farther apart than the margin and `more` during the whole step.
  bool farther(double more) const {
    return !come_within(a_, b_, scene_.margin + more, 0x1p-9) && !contained_at_start(scene_);
  }

 private:
  const Scene& scene_;
  MovingMesh a_, b_;
};

// ---- Random scenes.

class MovingTwinTest {
 public:
  explicit MovingTwinTest(unsigned seed) : random_(seed), small_(twin_bodies()), large_(large_twin_bodies()) {}

  void run(int pairs) {
    for (int i = 0; i < pairs && !testing::Test::HasFailure(); ++i) check(scene(i), i);
  }

  TwinFigures figures;
  int close = 0;  ///< of the rejected, not proven apart by 1e-4 of the size more
  int large = 0;  ///< pairs with a body of 1,000 triangles or more

 private:
  /// From `start`: turned about the centre, which moves by at most `way`.
  Motion turned(const Body& body, const Pose& start, double angle, double way) {
    Motion motion = Motion::resting(start);
    const Vector axis = random_.direction();
    motion.end.linear() = Eigen::AngleAxisd(random_.uniform(-angle, angle), axis) * start.linear();
    const Vector by = random_.direction() * random_.uniform(0, way);
    motion.end.translation() += body.centre(start) + by - body.centre(motion.end);
    return motion;
  }

  Motion motion(const Body& body, const Pose& start) {
    const double size = body.diagonal();
    switch (random_.below(8)) {
      case 0: return Motion::resting(start);
      case 1: return turned(body, start, 0, 2 * size);
      case 2: return turned(body, start, 3.054, 1.5 * size);  // 175 degrees
      case 3: return turned(body, start, 3.054, 0.1 * size);
      case 4: return turned(body, start, 0.8, 0.5 * size);
      default: return turned(body, start, 0.1, 0.1 * size);
    }
  }

  /// Every 64th pair has a large body, every 256th has two.
  Scene scene(int number) {
    const Body& a = random_.one_of(number % 256 == 0 ? large_ : small_);
    const Body& b = random_.one_of(number % 64 == 0 ? large_ : small_);
    Scene scene{a, b, motion(a, random_.pose()), motion(b, random_.pose()), random_.margin(a, b)};
    const unsigned kind = random_.below(16);
    if (kind == 0) share_motion(scene);
    if (kind < 3) {
      place(b, scene.motion_b,
            a.centre(scene.motion_a.start) + random_.direction() * random_.uniform(0, 2) * scene.size());
    } else if (kind < 5) {
      on_lattice(scene);
    } else {
      if (kind < 7) share_motion(scene);
      if (kind == 7) scene.motion_a.end = scene.motion_a.start;
      near_contact(scene);
    }
    return scene;
  }

  /// The same motion of both, but for rounding: what touches or is contained does so throughout.
  void share_motion(Scene& scene) {
    // With the inverse of an affine map: a pose's own would double what it is off from rigid.
    const Eigen::Affine3d both = Eigen::Affine3d(scene.motion_a.end) * Eigen::Affine3d(scene.motion_a.start).inverse();
    scene.motion_b.end.matrix() = (both * Eigen::Affine3d(scene.motion_b.start)).matrix();
  }

  /// On a line, close to where the answer changes: grazing contact, at any time of the step.
  void near_contact(Scene& scene) {
    const Vector start = random_.meeting_place(scene.a, scene.motion_a.start, scene.b, scene.motion_b.start);
    const Vector d = random_.direction();
    const auto answer = [&](double t) {
      place(scene.b, scene.motion_b, start + d * t);
      return scene.ask().separated;
    };
    random_.near_change(answer, random_.uniform(0.2, 3) * scene.size() + scene.margin, scene.size());
  }

  /// Faces, edges and vertices that slide along each other, meet exactly or miss by units in the last place.
  void on_lattice(Scene& scene) {
    const auto lattice_motion = [&](const Body& body, Motion& motion) {
      motion.start.linear() = random_.quarter_turns();
      motion.end.linear() = motion.start.linear();
      // Of a quarter turn at most: half a turn is not usable.
      if (random_.below(4) == 0) motion.end.linear().col(0).swap(motion.end.linear().col(1));
      if (motion.end.linear() != motion.start.linear()) motion.end.linear().col(0) *= -1;
      motion.end.translation() += body.centre(motion.start) + random_.lattice_point() - body.centre(motion.end);
    };
    lattice_motion(scene.a, scene.motion_a);
    lattice_motion(scene.b, scene.motion_b);
    place(scene.b, scene.motion_b, scene.a.centre(scene.motion_a.start) + random_.lattice_point());
    if (random_.below(2) == 0) {
      double& x = scene.motion_b.end.translation()[random_.below(3)];
      x = std::nextafter(x, random_.below(2) == 0 ? 1e300 : -1e300);
    }
  }

  void check(const Scene& scene, int number) {
    const Verdict verdict = scene.ask();
    const auto is_large = [](const Body& body) { return body.sample.source.triangles.rows() >= 1'000; };
    large += is_large(scene.a) || is_large(scene.b);
    if (verdict.separated) {
      ++figures.rejected;
      close += !scene.ask(1e-4 * scene.size()).separated;
      EXPECT_EQ(Twin(scene).truth(), Truth::apart)
          << "pair " << number << ": " << scene.a.sample.name << " and " << scene.b.sample.name << ", margin "
          << scene.margin << ", stage " << static_cast<int>(verdict.stage) << ", level " << verdict.level;
    }
    if (number % 10 == 0) count(scene, verdict.separated);
  }

  void count(const Scene& scene, bool separated) {
    ++figures.asked;
    if (!separated) figures.contacts += Twin(scene).touch() != Truth::apart;
    if (!shows_rate(scene.a, scene.b)) return;
    if (!Twin(scene).farther(0.01 * std::max(scene.a.diagonal(), scene.b.diagonal()))) return;
    ++figures.far;
    figures.far_kept += !separated;
  }

  TwinRandom random_;
  std::vector<Body> small_, large_;
};

constexpr int shards = 4;

class SeparatedMoving : public testing::TestWithParam<int> {};

TEST_P(SeparatedMoving, NeverMissesAContactOfBruteForce) {
  const int pairs = number_from("ENCAGE_TWIN_PAIRS", 12'000) / shards;
  MovingTwinTest twin(static_cast<unsigned>(number_from("ENCAGE_TWIN_SEED", 1) * shards + GetParam()));
  twin.run(pairs);
  const TwinFigures& figures = twin.figures;
  figures.record();
  RecordProperty("close", twin.close);
  RecordProperty("large", twin.large);
  // The test attacks only if both answers are common, and close ones among them.
  EXPECT_GT(figures.rejected, pairs / 5);
  EXPECT_GT(twin.close, pairs / 20);
  EXPECT_GE(twin.large, pairs / 100);
  EXPECT_LE(figures.far_kept, figures.far / 100);
  // Shares of fewer than these are chance (sanitizers run few pairs).
  if (figures.asked < 50) return;
  EXPECT_GT(figures.contacts, figures.asked / 10);
  EXPECT_GT(figures.far, figures.asked / 20);
}

INSTANTIATE_TEST_SUITE_P(Shards, SeparatedMoving, testing::Range(0, shards));

}  // namespace
}  // namespace encage::test
