// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/measure.h"

#include "bench/common/clock.h"
#include "bench/common/statistics.h"

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>

namespace encage::tank {
namespace {

std::int64_t touching_bodies(const Detection& detection) {
  std::set<std::int32_t> bodies;
  for (const BodyContact& contact : detection.contacts) bodies.insert({contact.body_a, contact.body_b});
  return static_cast<std::int64_t>(bodies.size());
}

/// A strategy, what it answered and what it took.
struct StrategyRun {
  Strategy strategy;
  std::vector<std::int64_t> steps;   ///< those it was asked about, increasing
  std::vector<Detection> answers;    ///< as `steps`
  std::vector<double> milliseconds;  ///< as `steps`
};

class Meter {
 public:
  Meter(const TankBody& body, const bench::Recording& recording, const MeasureOptions& options)
      : body_(body), steps_(recording.steps), options_(options) {
    const auto count = static_cast<std::int64_t>(steps_.size());
    all_ = bench::evenly_spread(count, count);
    sample_ = bench::evenly_spread(count, options.rebuild_steps);
  }

  Measurement run() {
    Measurement result;
    result.steps = static_cast<std::int64_t>(all_.size());
    result.sampled_steps = static_cast<std::int64_t>(sample_.size());
    leave_out(result);
    for (const Baseline baseline : {Baseline::rebuild_kdop, Baseline::rebuild_embree, Baseline::prebuilt}) {
      if (baseline != Baseline::prebuilt && sample_.empty()) continue;
      for (const CageUse cages : {CageUse::never, CageUse::always, CageUse::automatic}) {
        if (cages == CageUse::automatic && baseline != Baseline::prebuilt) continue;  // there is no fine tree to ask
        contestants_.push_back({make_strategy(body_, baseline, cages, options_.strategy),
                                baseline == Baseline::prebuilt ? all_ : sample_,
                                {},
                                {}});
      }
    }
    prebuilt_ = contestants_.size() - prebuilt_count;
    run_prebuilt();
    if (!sample_.empty()) run_rebuild();
    summarize(result);
    find_faults(result);
    return result;
  }

 private:
  void leave_out(Measurement& result) {
    for (const bench::RecordedStep& step : steps_) {
      left_out_.push_back(pairs_in_contact_at_start(body_, step));
      result.left_out += static_cast<std::int64_t>(left_out_.back().size());
      report(left_out_.size(), steps_.size(), "pairs in contact at the start of a step");
    }
  }

  void run_prebuilt() {
    const std::size_t total = prebuilt_count * all_.size() * static_cast<std::size_t>(options_.runs);
    std::size_t done = 0;
    std::array<std::vector<std::vector<double>>, prebuilt_count> times;
    times.fill(std::vector<std::vector<double>>(all_.size()));
    for (int r = 0; r < options_.runs; ++r) {
      for (std::size_t s = 0; s < prebuilt_count; ++s) {
        StrategyRun& contestant = contestants_[prebuilt_ + s];
        contestant.answers.resize(all_.size());
        for (std::size_t i = 0; i < all_.size(); ++i) {
          times[s][i].push_back(time(contestant.strategy, all_[i], contestant.answers[i]));
          report(++done, total, "prebuilt trees");
        }
      }
    }
    for (std::size_t s = 0; s < prebuilt_count; ++s) {
      for (std::vector<double>& runs : times[s])
        contestants_[prebuilt_ + s].milliseconds.push_back(bench::median(runs));
    }
  }

  void run_rebuild() {
    warm_up();
    const std::size_t total = prebuilt_ * sample_.size();
    std::size_t done = 0;
    for (const std::int64_t i : sample_) {
      for (std::size_t s = 0; s < prebuilt_; ++s) {
        StrategyRun& contestant = contestants_[s];
        contestant.milliseconds.push_back(time(contestant.strategy, i, contestant.answers.emplace_back()));
        report(++done, total, "rebuilt trees");
      }
    }
  }

  // Trees touch their memory for the first time outside the clock, as they would in a long run.
  void warm_up() {
    for (std::size_t s = 0; s < prebuilt_; ++s) {
      const std::vector<Detection>& known = contestants_[prebuilt_ + s % 2].answers;
      const std::int64_t most = *std::max_element(sample_.begin(), sample_.end(), [&](std::int64_t i, std::int64_t j) {
        return known[i].bodies < known[j].bodies;
      });
      contestants_[s].strategy.detect(steps_[most], left_out_[most]);
    }
  }

  void summarize(Measurement& result) const {
    for (std::size_t s = 0; s < contestants_.size(); ++s) {
      const StrategyRun& contestant = contestants_[s];
      StrategyResult& r = result.strategies.emplace_back();
      r.name = contestant.strategy.name();
      r.rebuilds = s < prebuilt_;
      r.steps_timed = static_cast<std::int64_t>(contestant.steps.size());
      for (std::size_t i = 0; i < contestant.steps.size(); ++i) {
        r.ms_per_step += contestant.milliseconds[i] / static_cast<double>(contestant.steps.size());
        r.counts += contestant.answers[i].counts;
        if (std::binary_search(sample_.begin(), sample_.end(), contestant.steps[i])) {
          r.sampled_ms += contestant.milliseconds[i] / static_cast<double>(sample_.size());
        }
      }
      // The stages on bodies are the same for all baselines, and the prebuilt ones went through all steps.
      const std::size_t same = s < prebuilt_ ? prebuilt_ + s % 2 : s;
      for (const Detection& answer : contestants_[same].answers) r.bodies += answer.bodies;
    }
    result.counts = result.strategy("prebuilt+cages").counts;
    for (const Detection& answer : contestants_[prebuilt_].answers) result.oracle_bodies += touching_bodies(answer);
  }

  void find_faults(Measurement& result) const {
    for (const std::int64_t i : all_) {
      std::vector<const Detection*> answers;
      std::vector<std::size_t> numbers;
      for (std::size_t s = 0; s < contestants_.size(); ++s) {
        const std::vector<std::int64_t>& steps = contestants_[s].steps;
        const auto at = std::lower_bound(steps.begin(), steps.end(), i);
        if (at == steps.end() || *at != i) continue;
        answers.push_back(&contestants_[s].answers[at - steps.begin()]);
        numbers.push_back(s);
      }
      const std::vector<Faults> faults = compare(steps_[i], answers, options_.judge);
      for (std::size_t k = 0; k < numbers.size(); ++k) result.strategies[numbers[k]].faults += faults[k];
      report(static_cast<std::size_t>(i) + 1, all_.size(), "judging contacts");
    }
  }

  // Milliseconds.
  double time(Strategy& strategy, std::int64_t i, Detection& answer) const {
    return bench::cpu_milliseconds([&] { answer = strategy.detect(steps_[i], left_out_[i]); });
  }

  void report(std::size_t done, std::size_t total, std::string_view what) const {
    options_.progress(static_cast<double>(done) / static_cast<double>(total), what);
  }

  const TankBody& body_;
  const std::vector<bench::RecordedStep>& steps_;
  const MeasureOptions& options_;
  std::vector<std::int64_t> all_, sample_;  // indices of steps_
  std::vector<std::vector<IndexPair>> left_out_;
  static constexpr std::size_t prebuilt_count = 3;
  std::vector<StrategyRun> contestants_;  // without and with cages in turn; the last ones need no rebuilding
  std::size_t prebuilt_ = 0;              // the first of these
};

}  // namespace

const StrategyResult& Measurement::strategy(const std::string& name) const {
  for (const StrategyResult& result : strategies) {
    if (result.name == name) return result;
  }
  throw std::out_of_range("no strategy " + name);
}

double Measurement::speedup(const std::string& slow, const std::string& fast) const {
  return sampled_steps > 0 ? bench::ratio(strategy(slow).sampled_ms, strategy(fast).sampled_ms) : 0;
}

double Measurement::speedup_count() const {
  return bench::ratio(static_cast<double>(strategy("prebuilt").bodies),
                      static_cast<double>(strategy("prebuilt+cages").bodies));
}

Faults Measurement::faults() const {
  Faults sum;
  for (const StrategyResult& result : strategies) sum += result.faults;
  return sum;
}

Measurement measure(const TankBody& body, const bench::Recording& recording, const MeasureOptions& options) {
  return Meter(body, recording, options).run();
}

std::vector<IndexPair> pairs_in_contact_at_start(const TankBody& body, const bench::RecordedStep& step) {
  PairOptions options;
  options.cages = CageUse::never;
  const auto count = static_cast<std::int32_t>(step.bodies.size());
  std::vector<IndexPair> pairs;
  for (IndexPair pair; pair.a < count; ++pair.a) {
    for (pair.b = pair.a + 1; pair.b < count; ++pair.b) {
      const Motion a = Motion::resting(step.bodies[pair.a].motion.start);
      const Motion b = Motion::resting(step.bodies[pair.b].motion.start);
      if (!separated(*body.shape, a, *body.shape, b, options).separated) pairs.push_back(pair);
    }
  }
  return pairs;
}

}  // namespace encage::tank
