// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/distance/pairs.h"

#include "bench/common/recorded_poses.h"
#include "bench/common/statistics.h"

#include <encage/error.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace encage::distances {
namespace {

TrianglePair nearest_before(const Shape& shape, const PoseStep& before, std::int32_t body_a, std::int32_t body_b) {
  const BodyPose *a = bench::find_body(before, body_a), *b = bench::find_body(before, body_b);
  if (a == nullptr || b == nullptr) return {-1, -1};
  const DistanceResult found = distance(shape, Motion::resting(a->pose), shape, Motion::resting(b->pose));
  return {found.triangle_a, found.triangle_b};
}

std::vector<DistancePair> some_of(const std::vector<DistancePair>& all, std::size_t most) {
  std::vector<DistancePair> some;
  for (const std::int64_t i : bench::evenly_spread(std::ssize(all), static_cast<std::int64_t>(most))) {
    some.push_back(all[static_cast<std::size_t>(i)]);
  }
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
  for (PairClass& one : classes) one.pairs = some_of(one.pairs, most);
  std::erase_if(classes, [](const PairClass& one) { return one.pairs.empty(); });
  return classes;
}

}  // namespace encage::distances
