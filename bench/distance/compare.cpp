// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/distance/compare.h"

#include "bench/replay/fcl_model.h"
#include "bench/tank/cpu_clock.h"

#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

namespace encage::distances {
namespace {

/// Bounds that a way gives; the upper one is infinite if it gives none.
struct Answer {
  double lower = 0, upper = 0;
};

struct Contestant {
  std::string name;
  std::function<Answer(const Pair&)> ask;
};

/// FCL finds one number, and some negative one of meshes that touch.
template <class Volume>
Contestant fcl_contestant(const std::string& name, const TriangleMesh& mesh) {
  const auto model = replay::make_fcl_model<Volume>(mesh);
  return {name, [model](const Pair& pair) {
            ::fcl::DistanceResultd result;
            ::fcl::distance(model.get(), pair.a.start, model.get(), pair.b.start, ::fcl::DistanceRequestd(), result);
            const double found = std::max(0.0, result.min_distance);
            return Answer{found, found};
          }};
}

Contestant exact(const std::string& name, const Shape& shape, bool hints, double tolerance) {
  return {name, [&shape, hints, tolerance](const Pair& pair) {
            const TrianglePair hint = hints ? pair.hint : TrianglePair{-1, -1};
            const DistanceResult found = distance(shape, pair.a, shape, pair.b, {.tolerance = tolerance, .hint = hint});
            return Answer{found.lower, found.upper};
          }};
}

Contestant cages(const std::string& name, const Shape& shape, int level, double part) {
  return {name, [&shape, level, part](const Pair& pair) {
            CageDistanceOptions options{.finest_cage = level, .coarsest_cage = level};
            if (part > 0 && pair.truth.lower > 0) options.enough = part * pair.truth.lower;
            return Answer{cage_distance_bound(shape, pair.a, shape, pair.b, options),
                          std::numeric_limits<double>::infinity()};
          }};
}

std::vector<Contestant> contestants(const Shape& shape, const TriangleMesh& mesh) {
  std::vector<Contestant> all;
  for (int level = level_count(shape) - 1; level >= 0; --level) {
    const std::string name = "cage of " + std::to_string(level_triangles(shape, level));
    all.push_back(cages(name, shape, level, 0));
    all.push_back(cages(name + ", is it half the distance?", shape, level, 0.5));
  }
  all.push_back(exact("exact", shape, false, 0));
  all.push_back(exact("exact, hint of the step before", shape, true, 0));
  all.push_back(exact("exact to 1 %", shape, false, 0.01));
  all.push_back(fcl_contestant<::fcl::OBBRSSd>("FCL, OBBRSS", mesh));
  all.push_back(fcl_contestant<::fcl::RSSd>("FCL, RSS", mesh));
  return all;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Whether what is said cannot be. FCL rounds in double, some 1e-12 of the places.
bool contradicts(const Answer& answer, const DistanceResult& truth) {
  const double slack = 1e-12 * (1 + truth.upper);
  return answer.lower > truth.upper + slack || answer.upper < truth.lower - slack;
}

Row row(const Contestant& contestant, const std::vector<Pair>& pairs, int runs) {
  Row result{.name = contestant.name};
  std::vector<std::vector<double>> times(pairs.size());
  std::vector<double> medians, parts;
  for (int run = 0; run < runs; ++run) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const double start = tank::thread_cpu_seconds();
      const Answer answer = contestant.ask(pairs[i]);
      times[i].push_back(1e6 * (tank::thread_cpu_seconds() - start));
      if (run > 0) continue;
      result.wrong += contradicts(answer, pairs[i].truth);
      if (pairs[i].truth.lower > 0) parts.push_back(answer.lower / pairs[i].truth.lower);
    }
  }
  for (const std::vector<double>& of_pair : times) medians.push_back(median(of_pair));
  result.median_us = median(medians);
  for (const double m : medians) result.mean_us += m / static_cast<double>(medians.size());
  result.tightness = median(parts);
  return result;
}

}  // namespace

std::vector<ClassRows> compare(const Shape& shape, const TriangleMesh& mesh, const std::vector<PairClass>& classes,
                               int runs, const std::function<void(double fraction)>& progress) {
  const std::vector<Contestant> all = contestants(shape, mesh);
  std::vector<ClassRows> result;
  double done = 0;
  for (const PairClass& one : classes) {
    ClassRows& rows = result.emplace_back(ClassRows{one.name, static_cast<std::int64_t>(one.pairs.size()), {}});
    for (const Contestant& contestant : all) {
      rows.rows.push_back(row(contestant, one.pairs, runs));
      progress(++done / static_cast<double>(classes.size() * all.size()));
    }
  }
  return result;
}

}  // namespace encage::distances
