// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/micro/benches.h"
#include "broadphase/motion/pair_motion.h"
#include "broadphase/motion/turned_box.h"
#include "broadphase/shape/shape.h"
#include "broadphase/shape/world_box.h"

#include <encage/contact.h>
#include <encage/distance.h>
#include <encage/self.h>

#include <algorithm>
#include <string>
#include <vector>

namespace encage::micro {
namespace {

std::vector<Case> resting(const std::vector<Case>& cases) {
  std::vector<Case> all;
  for (const Case& c : cases) all.push_back(c.at_rest());
  return all;
}

std::vector<Motion> resting(const std::vector<Motion>& motions) {
  std::vector<Motion> all;
  for (const Motion& m : motions) all.push_back(Motion::resting(m.start));
  return all;
}

/// Which share of the pairs a test rejects comes with it as a counter.
void add_test(const std::string& name, const Shape& shape, const std::vector<Case>& cases, const PairOptions& options) {
  benchmark::RegisterBenchmark(name.c_str(), [&shape, &cases, options](benchmark::State& state) {
    const auto rejects = [&](const Case& c) { return separated(shape, c.a, shape, c.b, options).separated; };
    const auto rejected = std::count_if(cases.begin(), cases.end(), rejects);
    state.counters["rejected"] = static_cast<double>(rejected) / static_cast<double>(cases.size());
    ask_in_turn(state, cases, rejects);
  });
}

/// Every stage alone, and each cage level with the fine mesh behind it.
void add_tests(const std::string& how, const Shape& shape, const std::vector<Case>& cases) {
  const std::string name = "stage/separated/" + how + "/";
  PairOptions none;
  none.boxes = none.fine = false;
  none.cages = CageUse::never;
  PairOptions boxes = none;
  boxes.boxes = true;
  add_test(name + "boxes", shape, cases, boxes);
  for (int k = level_count(shape) - 1; k >= 0; --k) {
    PairOptions cage = none;
    cage.cages = CageUse::always;
    cage.finest_cage = cage.coarsest_cage = k;
    add_test(name + "cage_" + std::to_string(k), shape, cases, cage);
    cage.fine = true;
    add_test(name + "cage_" + std::to_string(k) + "+fine", shape, cases, cage);
  }
  PairOptions all = none;
  all.cages = CageUse::always;
  add_test(name + "cages", shape, cases, all);
  all.fine = true;
  add_test(name + "cages+fine", shape, cases, all);
  all.cages = CageUse::never;
  add_test(name + "fine", shape, cases, all);
}

int candidates(const Shape& shape, const Case& c) {
  int count = 0;
  for_each_triangle_pair(shape, c.a, shape, c.b, 0, [&](TrianglePair) {
    ++count;
    return true;
  });
  return count;
}

/// The ground, into which the body's box reaches, or just below it.
HalfSpace ground(const Shape& shape, const Motion& motion, bool reached) {
  const double height = world_box(shape, motion).min().z();
  return {Eigen::Vector3d::UnitZ(), height + (reached ? 0.01 : -0.01) * shape.simple().frame.radius};
}

struct BodyOnGround {
  Motion motion;
  HalfSpace plane;
};

std::vector<BodyOnGround> on_ground(const Shape& shape, const std::vector<Motion>& motions, bool reached) {
  std::vector<BodyOnGround> all;
  for (const Motion& m : motions) all.push_back({m, ground(shape, m, reached)});
  return all;
}

}  // namespace

void add_stages(const Workload& w) {
  static const std::vector<Case> cases_at_rest = resting(w.cases);
  static const std::vector<Motion> bodies_at_rest = resting(w.bodies);
  const Shape& shape = *w.shape;
  static const Eigen::AlignedBox3d body_box = world_box(shape, Motion{});
  add("stage/ball_box", w.bodies, [&](const Motion& m) { return ball_box(shape, {m.start, 1}); });
  add("stage/turned_box", w.bodies, [](const Motion& m) { return turned_box(body_box, m.start); });
  add("stage/world_box/rest", bodies_at_rest, [&](const Motion& m) { return world_box(shape, m); });
  add("stage/world_box/moving", w.bodies, [&](const Motion& m) { return world_box(shape, m); });
  add_tests("rest", shape, cases_at_rest);
  add_tests("moving", shape, w.cases);
  static const std::vector<BodyOnGround> resting_on = on_ground(shape, bodies_at_rest, true),
                                         landing = on_ground(shape, w.bodies, true),
                                         above = on_ground(shape, w.bodies, false);
  const auto reaches = [&](const BodyOnGround& b) { return separated(shape, b.motion, b.plane); };
  add("stage/half_space/reached/rest", resting_on, reaches);
  add("stage/half_space/reached/moving", landing, reaches);
  add("stage/half_space/free/moving", above, reaches);
  add("stage/half_space/distance", resting_on,
      [&](const BodyOnGround& b) { return encage::distance(shape, b.motion, b.plane).lower; });
  if (shape.simple().fine.empty()) return;
  static const std::vector<int> once(1);
  add("stage/self/intersects", once, [&](int) { return self_intersects(shape).answer; });
  add("stage/self/distance", once, [&](int) { return self_distance(shape).lower; });
  add("stage/candidates/rest", cases_at_rest, [&](const Case& c) { return candidates(shape, c); });
  add("stage/candidates/moving", w.cases, [&](const Case& c) { return candidates(shape, c); });
  add("stage/first_contact", w.cases, [&](const Case& c) { return first_contact(shape, c.a, shape, c.b); });
}

}  // namespace encage::micro
