// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/distance/pairs.h"

#include <encage/error.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace encage::distances {
namespace {

/// Where the body is in a step, if at all.
const BodyPose* find(const PoseStep& step, std::int32_t body) {
  const auto at = std::lower_bound(step.bodies.begin(), step.bodies.end(), body,
                                   [](const BodyPose& b, std::int32_t number) { return b.body < number; });
  return at != step.bodies.end() && at->body == body ? &*at : nullptr;
}

TrianglePair nearest_before(const Shape& shape, const PoseStep& before, std::int32_t body_a, std::int32_t body_b) {
  const BodyPose *a = find(before, body_a), *b = find(before, body_b);
  if (a == nullptr || b == nullptr) return {-1, -1};
  const DistanceResult found = distance(shape, Motion::resting(a->pose), shape, Motion::resting(b->pose));
  return {found.triangle_a, found.triangle_b};
}

std::vector<DistancePair> evenly_spread(std::vector<DistancePair> all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<DistancePair> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(all[i * all.size() / most]);
  return some;
}

}  // namespace

std::vector<PairClass> make_pairs(const Shape& shape, double diagonal, const std::vector<PoseStep>& poses,
                                  std::int64_t every, std::size_t most) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::array<std::pair<const char*, double>, 6> limits = {{{"touching", 0},
                                                                 {"below 0.1 %", 1e-3},
                                                                 {"0.1 to 1 %", 1e-2},
                                                                 {"1 to 10 %", 1e-1},
                                                                 {"10 to 100 %", 1},
                                                                 {"above 100 %", infinity}}};
  std::vector<PairClass> classes;
  for (const auto& [name, limit] : limits) classes.push_back({name, {}});
  PairClass far{"10 diagonals and more", {}};
  for (std::size_t s = 0; s < poses.size(); s += static_cast<std::size_t>(every)) {
    const std::vector<BodyPose>& bodies = poses[s].bodies;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      for (std::size_t j = i + 1; j < bodies.size(); ++j) {
        DistancePair pair{Motion::resting(bodies[i].pose), Motion::resting(bodies[j].pose), {-1, -1}, {}};
        if (s > 0) pair.hint = nearest_before(shape, poses[s - 1], bodies[i].body, bodies[j].body);
        pair.truth = distance(shape, pair.a, shape, pair.b);
        const double part = pair.truth.lower / diagonal;
        const auto at = std::find_if(limits.begin(), limits.end(), [&](const auto& l) { return part <= l.second; });
        classes[static_cast<std::size_t>(at - limits.begin())].pairs.push_back(pair);
        const Eigen::Vector3d way = bodies[j].pose.translation() - bodies[i].pose.translation();
        pair.b.start.translation() += 11 * diagonal * way.normalized();
        pair.b.end = pair.b.start;
        pair.truth = distance(shape, pair.a, shape, pair.b);
        far.pairs.push_back(pair);
      }
    }
  }
  if (far.pairs.empty()) throw Error("the poses have no pairs of bodies");
  classes.push_back(std::move(far));
  for (PairClass& one : classes) one.pairs = evenly_spread(std::move(one.pairs), most);
  std::erase_if(classes, [](const PairClass& one) { return one.pairs.empty(); });
  return classes;
}

}  // namespace encage::distances
