// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/twins/scenes.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace encage::twins {

using test::Body;
using test::TwinRandom;
using Pose = Eigen::Isometry3d;
using Vector = Eigen::Vector3d;

namespace {

/// Returns a motion from `start` that turns about the centre, which moves by at most `way`.
Motion turned(TwinRandom& random, const Body& body, const Pose& start, double angle, double way) {
  Motion motion = Motion::resting(start, body.scale);
  const Vector axis = random.direction();
  motion.end.linear() = Eigen::AngleAxisd(random.uniform(-angle, angle), axis) * start.linear();
  const Vector by = random.direction() * random.uniform(0, way);
  motion.end.translation() += body.centre(start) + by - body.centre(motion.end);
  return motion;
}

/// Gives both bodies the same motion up to rounding: they then touch, or contain each other, throughout.
void share_motion(Scene& scene) {
  // This uses the inverse of an affine map, because that of a pose would double its departure from rigid.
  const Eigen::Affine3d both = Eigen::Affine3d(scene.motion_a.end) * Eigen::Affine3d(scene.motion_a.start).inverse();
  scene.motion_b.end.matrix() = (both * Eigen::Affine3d(scene.motion_b.start)).matrix();
}

/// Moves a body along a line close to where the answer changes: grazing contact, at any time of the step.
void near_change(TwinRandom& random, Scene& scene, double farthest, const Scenes::Query& query) {
  const Vector start = random.meeting_place(*scene.a, scene.motion_a.start, *scene.b, scene.motion_b.start);
  const Vector d = random.direction();
  const auto answer = [&](double t) {
    place(*scene.b, scene.motion_b, start + d * t);
    return query(scene);
  };
  random.near_change(answer, random.uniform(0.2, farthest) * scene.size() + scene.margin, scene.size());
}

void nudge(TwinRandom& random, Vector& v) {
  if (random.coin()) return;
  double& x = v[random.below(3)];
  for (unsigned i = random.below(4); i > 0; --i) x = std::nextafter(x, random.coin() ? 1e300 : -1e300);
}

/// Makes faces, edges and vertices meet exactly, or miss by some units in the last place.
void on_lattice_at_rest(TwinRandom& random, Scene& scene) {
  Pose pose_a = scene.motion_a.start, pose_b = scene.motion_b.start;
  pose_a.linear() = random.quarter_turns();
  pose_b.linear() = random.quarter_turns();
  pose_b.translation() += scene.a->centre(pose_a) + random.lattice_point() * scene.unit - scene.b->centre(pose_b);
  Vector translation = pose_b.translation();
  nudge(random, translation);
  pose_b.translation() = translation;
  scene.motion_a = Motion::resting(pose_a, scene.a->scale);
  scene.motion_b = Motion::resting(pose_b, scene.b->scale);
}

/// The same during a step: the bodies slide along each other, or meet at its end.
void on_lattice_moving(TwinRandom& random, Scene& scene) {
  const auto lattice_motion = [&](const Body& body, Motion& motion) {
    motion.start.linear() = random.quarter_turns();
    motion.end.linear() = motion.start.linear();
    // The turn is a quarter at most, because half a turn is not usable.
    if (random.below(4) == 0) motion.end.linear().col(0).swap(motion.end.linear().col(1));
    if (motion.end.linear() != motion.start.linear()) motion.end.linear().col(0) *= -1;
    const Vector by = random.lattice_point() * scene.unit;
    motion.end.translation() += body.centre(motion.start) + by - body.centre(motion.end);
  };
  lattice_motion(*scene.a, scene.motion_a);
  lattice_motion(*scene.b, scene.motion_b);
  place(*scene.b, scene.motion_b, scene.a->centre(scene.motion_a.start) + random.lattice_point() * scene.unit);
  Vector translation = scene.motion_b.end.translation();
  nudge(random, translation);
  scene.motion_b.end.translation() = translation;
}

std::vector<Body> kept(std::vector<Body> bodies, Scenes::Bodies which) {
  if (which == Scenes::Bodies::with_fine_mesh) {
    std::erase_if(bodies, [](const Body& body) { return !body.has_fine(); });
  }
  return bodies;
}

}  // namespace

Motion random_motion(TwinRandom& random, const Body& body, const Pose& start) {
  const double size = body.diagonal();
  switch (random.below(8)) {
    case 0: return Motion::resting(start, body.scale);
    case 1: return turned(random, body, start, 0, 2 * size);
    case 2: return turned(random, body, start, 3.054, 1.5 * size);  // 175 degrees
    case 3: return turned(random, body, start, 3.054, 0.1 * size);
    case 4: return turned(random, body, start, 0.8, 0.5 * size);
    default: return turned(random, body, start, 0.1, 0.1 * size);
  }
}

void place(const Body& body, Motion& motion, const Vector& where) {
  const Vector by = where - body.centre(motion.start);
  motion.start.translation() += by;
  motion.end.translation() += by;
}

std::string Scene::text() const {
  std::ostringstream out;
  out << a->sample.name << " and " << b->sample.name << ", unit " << unit << ", margin " << margin;
  return out.str();
}

Scenes::Scenes(Bodies bodies, bool large) {
  // The largest unit is beyond the range of the box gate, which must not prove anything wrong there.
  for (const int exponent : {0, -60, 60, 100}) {
    InUnit& unit = units_.emplace_back(InUnit{std::ldexp(1.0, exponent), {}, {}});
    unit.small = kept(test::twin_bodies(exponent), bodies);
    if (exponent == 0 && large) unit.large = kept(test::large_twin_bodies(), bodies);
  }
}

Scene Scenes::start(TwinRandom& random, std::int64_t number) const {
  const InUnit& in = random.below(16) == 0 ? units_[1 + random.below(3)] : units_[0];
  const auto one = [&](bool large) -> const Body& {
    return random.one_of(large && !in.large.empty() ? in.large : in.small);
  };
  Scene scene;
  scene.unit = in.unit;
  scene.a = &one(number % 512 == 0);
  scene.b = &one(number % 64 == 0);
  const auto pose = [&] {
    Pose p = random.pose();
    p.translation() *= in.unit;
    return p;
  };
  scene.motion_a = Motion::resting(pose(), scene.a->scale);
  scene.motion_b = Motion::resting(pose(), scene.b->scale);
  scene.margin = random.margin(*scene.a, *scene.b);
  return scene;
}

Scene Scenes::resting(TwinRandom& random, std::int64_t number, const Query& query) const {
  Scene scene = start(random, number);
  const unsigned kind = random.below(8);
  if (kind < 2) {
    place(*scene.b, scene.motion_b,
          scene.a->centre(scene.motion_a.start) + random.direction() * random.uniform(0, 1.2) * scene.size());
  } else if (kind < 7) {
    near_change(random, scene, 1.5, query);
  } else {
    on_lattice_at_rest(random, scene);
  }
  return scene;
}

Scene Scenes::moving(TwinRandom& random, std::int64_t number, const Query& query) const {
  Scene scene = start(random, number);
  scene.motion_a = random_motion(random, *scene.a, scene.motion_a.start);
  scene.motion_b = random_motion(random, *scene.b, scene.motion_b.start);
  const unsigned kind = random.below(16);
  if (kind == 0) share_motion(scene);
  if (kind < 3) {
    place(*scene.b, scene.motion_b,
          scene.a->centre(scene.motion_a.start) + random.direction() * random.uniform(0, 2) * scene.size());
  } else if (kind < 5) {
    on_lattice_moving(random, scene);
  } else {
    if (kind < 7) share_motion(scene);
    if (kind == 7) scene.motion_a.end = scene.motion_a.start;
    near_change(random, scene, 3, query);
  }
  return scene;
}

}  // namespace encage::twins
