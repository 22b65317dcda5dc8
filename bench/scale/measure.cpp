// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/scale/measure.h"

#include "bench/tank/cpu_clock.h"

#include <algorithm>
#include <cmath>

namespace encage::scale {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<PairKey> all_pairs(const Frame& frame) {
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
struct Contestant {
  const EngineKind& kind;
  std::vector<std::vector<double>> ms;
  std::vector<double> pairs;
  int wrong_steps = 0;
};

class Race {
 public:
  Race(const SceneOptions& scene, const std::vector<ShapePtr>& shapes, const MeasureOptions& options)
      : scene_(scene), shapes_(shapes), options_(options), expected_(steps()) {
    for (const std::string& name : options.engines) {
      const EngineKind& kind = engine_kind(name);
      if (kind.most_bodies >= scene.bodies)
        contestants_.push_back({kind, std::vector<std::vector<double>>(timed()), {}});
    }
    result_.bodies = scene.bodies;
    result_.brute_force = scene.bodies <= options.brute_force;
  }

  void run(const std::function<void()>& turn) {
    for (int i = 0; i < options_.runs; ++i) {
      for (Contestant& c : contestants_) {
        go(c, i == 0);
        turn();
      }
    }
  }

  Measurement result() {
    for (const Contestant& c : contestants_) {
      EngineTimes times{c.kind.name};
      for (const std::vector<double>& runs : c.ms) {
        const double ms = median(runs);
        times.ms += ms / options_.steps;
        times.worst_ms = std::max(times.worst_ms, ms);
      }
      for (const double pairs : c.pairs) times.pairs += pairs / static_cast<double>(c.pairs.size());
      times.wrong_steps = c.wrong_steps;
      result_.engines.push_back(times);
    }
    return result_;
  }

 private:
  std::size_t timed() const { return static_cast<std::size_t>(options_.steps); }
  std::size_t steps() const { return timed() + static_cast<std::size_t>(options_.warm_up); }

  void go(Contestant& c, bool check) {
    Scene scene(scene_, shapes_);
    const std::unique_ptr<Engine> engine = c.kind.make(scene);
    std::vector<PairKey> pairs;
    double boxes = 0, moved = 0, found = 0;
    for (std::size_t i = 0; i < steps(); ++i) {
      const double box_seconds = scene.advance();
      pairs.clear();
      double seconds = 0;
      {
        const tank::CpuTimer timer(seconds);
        engine->step(scene.frame(), pairs);
      }
      if (check) compare(c, i, scene.frame(), pairs);
      if (i + timed() < steps()) continue;
      c.ms[i - (steps() - timed())].push_back(1e3 * seconds);
      boxes += 1e3 * box_seconds / options_.steps;
      moved += static_cast<double>(scene.frame().moved.size()) / options_.steps;
      found += static_cast<double>(pairs.size()) / options_.steps;
    }
    c.pairs.push_back(found);
    result_.boxes_ms = boxes;
    result_.moved = moved;
    if (c.kind.boxes_only) result_.pairs = found;
  }

  void compare(Contestant& c, std::size_t step, const Frame& frame, const std::vector<PairKey>& pairs) {
    if (!c.kind.boxes_only) return;
    const std::uint64_t print = fingerprint(pairs);
    if (first_ == nullptr) first_ = &c;
    if (first_ == &c) {
      expected_[step] = result_.brute_force ? fingerprint(all_pairs(frame)) : print;
    }
    if (print != expected_[step]) ++c.wrong_steps;
  }

  SceneOptions scene_;
  const std::vector<ShapePtr>& shapes_;
  MeasureOptions options_;
  std::vector<Contestant> contestants_;
  const Contestant* first_ = nullptr;
  std::vector<std::uint64_t> expected_;  // of each step
  Measurement result_;
};

}  // namespace

Measurement measure(const SceneOptions& scene, const std::vector<ShapePtr>& shapes, const MeasureOptions& options,
                    const std::function<void()>& turn) {
  Race race(scene, shapes, options);
  race.run(turn);
  return race.result();
}

double exponent(const std::vector<double>& bodies, const std::vector<double>& times) {
  const auto count = static_cast<double>(bodies.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double u = std::log(bodies[i]), v = std::log(times[i]);
    x += u;
    y += v;
    xx += u * u;
    xy += u * v;
  }
  const double spread = count * xx - x * x;
  return spread > 0 ? (count * xy - x * y) / spread : 0;
}

}  // namespace encage::scale
