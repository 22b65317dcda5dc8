// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/suite/scale/measure.h"

#include "bench/common/clock.h"
#include "bench/common/step_times.h"

#include <algorithm>

namespace encage::scale {
namespace {

std::vector<PairKey> all_pairs(const ScaleFrame& frame) {
  std::vector<PairKey> pairs;
  const auto count = static_cast<std::uint32_t>(frame.box.size());
  for (std::uint32_t a = 0; a < count; ++a) {
    for (std::uint32_t b = a + 1; b < count; ++b) {
      if (frame.box[a].intersects(frame.box[b])) pairs.push_back(pair_key(a, b));
    }
  }
  return pairs;
}

/// Of a set of pairs, whatever their order.
std::uint64_t fingerprint(const std::vector<PairKey>& pairs) {
  std::uint64_t sum = pairs.size();
  for (PairKey key : pairs) {
    key = (key ^ key >> 31) * 0x9e3779b97f4a7c15u;
    sum += (key ^ key >> 29) * 0xbf58476d1ce4e5b9u;
  }
  return sum;
}

/// What becomes of one engine in all runs.
struct Runner {
  const BroadPhaseKind& kind;
  bench::StepTimes times;
  std::vector<double> pairs;
  int wrong_steps = 0;
};

class Race {
 public:
  Race(const ScaleSceneOptions& scene, const std::vector<ShapePtr>& shapes, const RaceOptions& options)
      : scene_(scene), shapes_(shapes), options_(options), expected_(steps()) {
    for (const std::string& name : options.engines) {
      const BroadPhaseKind& kind = broad_phase_kind(name);
      if (kind.most_bodies >= scene.bodies) runners_.push_back({kind, bench::StepTimes(timed()), {}});
    }
    result_.bodies = scene.bodies;
    result_.brute_force = scene.bodies <= options.brute_force;
  }

  void run(const std::function<void()>& turn) {
    for (int i = 0; i < options_.runs; ++i) {
      for (Runner& c : runners_) {
        go(c, i == 0);
        turn();
      }
    }
  }

  RaceResult result() {
    for (const Runner& c : runners_) {
      BroadPhaseTimes times{c.kind.name};
      times.ms = c.times.mean_of_medians();
      times.worst_ms = c.times.worst_median();
      for (const double pairs : c.pairs) times.pairs += pairs / static_cast<double>(c.pairs.size());
      times.wrong_steps = c.wrong_steps;
      result_.engines.push_back(times);
    }
    return result_;
  }

 private:
  std::size_t timed() const { return static_cast<std::size_t>(options_.steps); }
  std::size_t steps() const { return timed() + static_cast<std::size_t>(options_.warm_up); }

  void go(Runner& c, bool check) {
    ScaleScene scene(scene_, shapes_);
    const std::unique_ptr<BroadPhase> engine = c.kind.make(scene);
    std::vector<PairKey> pairs;
    double boxes = 0, moved = 0, found = 0;
    for (std::size_t i = 0; i < steps(); ++i) {
      const double box_seconds = scene.advance();
      pairs.clear();
      double seconds = 0;
      {
        const bench::CpuTimer timer(seconds);
        engine->step(scene.frame(), pairs);
      }
      if (check) compare(c, i, scene.frame(), pairs);
      if (i + timed() < steps()) continue;
      c.times.add(i - (steps() - timed()), 1e3 * seconds);
      boxes += 1e3 * box_seconds / options_.steps;
      moved += static_cast<double>(scene.frame().moved.size()) / options_.steps;
      found += static_cast<double>(pairs.size()) / options_.steps;
    }
    c.pairs.push_back(found);
    result_.boxes_ms = boxes;
    result_.moved = moved;
    if (c.kind.boxes_only) result_.pairs = found;
  }

  void compare(Runner& c, std::size_t step, const ScaleFrame& frame, const std::vector<PairKey>& pairs) {
    if (!c.kind.boxes_only) return;
    const std::uint64_t print = fingerprint(pairs);
    if (first_ == nullptr) first_ = &c;
    if (first_ == &c) {
      expected_[step] = result_.brute_force ? fingerprint(all_pairs(frame)) : print;
    }
    if (print != expected_[step]) ++c.wrong_steps;
  }

  ScaleSceneOptions scene_;
  const std::vector<ShapePtr>& shapes_;
  RaceOptions options_;
  std::vector<Runner> runners_;
  const Runner* first_ = nullptr;
  std::vector<std::uint64_t> expected_;  // of each step
  RaceResult result_;
};

}  // namespace

RaceResult race(const ScaleSceneOptions& scene, const std::vector<ShapePtr>& shapes, const RaceOptions& options,
                const std::function<void()>& turn) {
  Race race(scene, shapes, options);
  race.run(turn);
  return race.result();
}

}  // namespace encage::scale
