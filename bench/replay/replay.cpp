// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/replay.h"

#include <algorithm>
#include <set>

#include "bench/tank/cpu_clock.h"

namespace encage::replay {
namespace {

/// An engine, alone or behind the gate.
struct Contestant {
  Engine* engine;
  const CageGate* gate;
  std::string name;
  std::vector<std::vector<double>> milliseconds;  // per step, of all runs
  std::vector<std::vector<BodyPair>> answers;     // per step
};

double mean_of_medians(std::vector<std::vector<double>> runs) {
  double sum = 0;
  for (std::vector<double>& times : runs) {
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    sum += *middle;
  }
  return runs.empty() ? 0 : sum / static_cast<double>(runs.size());
}

void ask(Contestant& contestant, const std::vector<PoseStep>& steps, std::size_t i) {
  const double start = tank::thread_cpu_seconds();
  std::vector<BodyPair> answer = contestant.engine->touching(steps[i], contestant.gate);
  contestant.milliseconds[i].push_back(1e3 * (tank::thread_cpu_seconds() - start));
  contestant.answers[i] = std::move(answer);
}

void find_disagreements(const std::vector<Contestant>& contestants, const std::vector<PoseStep>& steps, std::size_t i,
                        std::vector<Disagreement>& disagreements) {
  std::set<BodyPair> pairs;
  for (const Contestant& contestant : contestants)
    pairs.insert(contestant.answers[i].begin(), contestant.answers[i].end());
  for (const BodyPair& pair : pairs) {
    Disagreement disagreement{steps[i].step, pair, {}};
    for (const Contestant& c : contestants) {
      if (std::binary_search(c.answers[i].begin(), c.answers[i].end(), pair)) disagreement.touching.push_back(c.name);
    }
    if (disagreement.touching.size() < contestants.size()) disagreements.push_back(std::move(disagreement));
  }
}

}  // namespace

Replay replay(const std::vector<std::unique_ptr<Engine>>& engines, const CageGate* gate,
              const std::vector<PoseStep>& steps, int runs, const std::function<void(double fraction)>& progress) {
  std::vector<Contestant> contestants;
  const auto enter = [&](Engine* engine, const CageGate* g, const std::string& name) {
    contestants.push_back({engine, g, name, std::vector<std::vector<double>>(steps.size()),
                           std::vector<std::vector<BodyPair>>(steps.size())});
  };
  for (const std::unique_ptr<Engine>& engine : engines) {
    enter(engine.get(), nullptr, engine->name());
    if (gate) enter(engine.get(), gate, engine->name() + "+cages");
  }
  for (int r = 0; r < runs; ++r) {
    for (std::size_t i = 0; i < steps.size(); ++i) {
      for (Contestant& contestant : contestants) ask(contestant, steps, i);
      progress(static_cast<double>(r * steps.size() + i + 1) / static_cast<double>(runs * steps.size()));
    }
  }

  Replay result;
  result.steps = static_cast<std::int64_t>(steps.size());
  for (const Contestant& contestant : contestants) {
    const double ms = mean_of_medians(contestant.milliseconds);
    if (contestant.gate) {
      result.engines.back().with_cages_ms = ms;
      continue;
    }
    EngineResult& engine = result.engines.emplace_back();
    engine.name = contestant.name;
    engine.ms_per_step = ms;
    for (const auto& answer : contestant.answers) engine.touching += static_cast<std::int64_t>(answer.size());
  }
  for (std::size_t i = 0; i < steps.size(); ++i) find_disagreements(contestants, steps, i, result.disagreements);
  return result;
}

}  // namespace encage::replay
