// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/distance/compare.h"

#include "bench/common/clock.h"
#include "bench/common/fcl_model.h"
#include "bench/common/statistics.h"

#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

namespace encage::distances {
namespace {

/// Bounds that a way gives; the upper one is infinite if it gives none.
struct Bounds {
  double lower = 0, upper = 0;
};

struct DistanceWay {
  std::string name;
  std::function<Bounds(const DistancePair&)> ask;
};

/// FCL finds one number, and some negative one of meshes that touch.
template <class Volume>
DistanceWay fcl_way(const std::string& name, const TriangleMesh& mesh) {
  const auto model = bench::make_fcl_model<Volume>(mesh);
  return {name, [model](const DistancePair& pair) {
            ::fcl::DistanceResultd result;
            ::fcl::distance(model.get(), pair.a.start, model.get(), pair.b.start, ::fcl::DistanceRequestd(), result);
            const double found = std::max(0.0, result.min_distance);
            return Bounds{found, found};
          }};
}

DistanceWay exact(const std::string& name, const Shape& shape, bool hints, double tolerance) {
  return {name, [&shape, hints, tolerance](const DistancePair& pair) {
            const TrianglePair hint = hints ? pair.hint : TrianglePair{-1, -1};
            const DistanceResult found = distance(shape, pair.a, shape, pair.b, {.tolerance = tolerance, .hint = hint});
            return Bounds{found.lower, found.upper};
          }};
}

DistanceWay cages(const std::string& name, const Shape& shape, int level, double part) {
  return {name, [&shape, level, part](const DistancePair& pair) {
            CageDistanceOptions options{.finest_cage = level, .coarsest_cage = level};
            if (part > 0 && pair.truth.lower > 0) options.enough = part * pair.truth.lower;
            return Bounds{cage_distance_bound(shape, pair.a, shape, pair.b, options),
                          std::numeric_limits<double>::infinity()};
          }};
}

std::vector<DistanceWay> ways(const Shape& shape, const TriangleMesh& mesh) {
  std::vector<DistanceWay> all;
  for (int level = level_count(shape) - 1; level >= 0; --level) {
    const std::string name = "cage of " + std::to_string(level_triangles(shape, level));
    all.push_back(cages(name, shape, level, 0));
    all.push_back(cages(name + ", is it half the distance?", shape, level, 0.5));
  }
  all.push_back(exact("exact", shape, false, 0));
  all.push_back(exact("exact, hint of the step before", shape, true, 0));
  all.push_back(exact("exact to 1 %", shape, false, 0.01));
  all.push_back(fcl_way<::fcl::OBBRSSd>("FCL, OBBRSS", mesh));
  all.push_back(fcl_way<::fcl::RSSd>("FCL, RSS", mesh));
  return all;
}

/// Whether what is said cannot be. FCL rounds in double, some 1e-12 of the places.
bool contradicts(const Bounds& answer, const DistanceResult& truth) {
  const double slack = 1e-12 * (1 + truth.upper);
  return answer.lower > truth.upper + slack || answer.upper < truth.lower - slack;
}

DistanceRow row(const DistanceWay& way, const std::vector<DistancePair>& pairs, int runs) {
  DistanceRow result{.name = way.name};
  std::vector<std::vector<double>> times(pairs.size());
  std::vector<double> medians, parts;
  for (int run = 0; run < runs; ++run) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      Bounds answer;
      times[i].push_back(1e3 * bench::cpu_milliseconds([&] { answer = way.ask(pairs[i]); }));
      if (run > 0) continue;
      result.wrong += contradicts(answer, pairs[i].truth);
      if (pairs[i].truth.lower > 0) parts.push_back(answer.lower / pairs[i].truth.lower);
    }
  }
  for (const std::vector<double>& of_pair : times) medians.push_back(bench::median(of_pair));
  result.median_us = bench::median(medians);
  result.mean_us = bench::mean_of_medians(times);
  result.tightness = bench::median(parts);
  return result;
}

}  // namespace

std::vector<ClassRows> compare(const Shape& shape, const TriangleMesh& mesh, const std::vector<PairClass>& classes,
                               int runs, const std::function<void(double fraction)>& progress) {
  const std::vector<DistanceWay> all = ways(shape, mesh);
  std::vector<ClassRows> result;
  double done = 0;
  for (const PairClass& one : classes) {
    ClassRows& rows = result.emplace_back(ClassRows{one.name, static_cast<std::int64_t>(one.pairs.size()), {}});
    for (const DistanceWay& way : all) {
      rows.rows.push_back(row(way, one.pairs, runs));
      progress(++done / static_cast<double>(classes.size() * all.size()));
    }
  }
  return result;
}

}  // namespace encage::distances
