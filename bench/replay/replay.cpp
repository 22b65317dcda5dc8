// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/replay.h"

#include "bench/common/step_times.h"

#include <algorithm>
#include <set>
#include <utility>

namespace encage::replay {
namespace {

constexpr const char* perfect = "perfect";

/// An engine, alone or behind something.
struct Contestant {
  Engine* engine;
  std::string front;  // empty: alone
  const Gate* gate;   // not for `perfect`, whose gate knows one step
  bench::StepTimes times;
  std::vector<std::vector<BodyPair>> answers{};  // per step

  std::string name() const { return front.empty() ? engine->name() : engine->name() + "+" + front; }
};

std::vector<Contestant> contestants_of(Engine& engine, const PairQuestion& question) {
  std::vector<Contestant> list;
  const auto enter = [&](const std::string& front, const Gate* gate) {
    list.push_back({&engine, front, gate, bench::StepTimes(question.steps.size())});
    list.back().answers.resize(question.steps.size());
  };
  enter("", nullptr);
  for (const Front& front : question.fronts) {
    if (engine.gains_from(*front.gate)) enter(front.name, front.gate);
  }
  enter(perfect, nullptr);
  return list;
}

/// What an engine builds at the first sight of bodies does not count.
void warm_up(Engine& engine, const std::vector<PoseStep>& steps) {
  const auto most = std::max_element(steps.begin(), steps.end(), [](const PoseStep& s, const PoseStep& t) {
    return s.bodies.size() < t.bodies.size();
  });
  if (most != steps.end()) engine.touching({*most});
}

void ask(Contestant& contestant, const PairQuestion& question, std::size_t i) {
  const std::vector<BodyPair>* left_out = question.left_out.empty() ? nullptr : &question.left_out[i];
  const PerfectGate knows(question.truth[i]);
  const Gate* gate = contestant.front == perfect ? &knows : contestant.gate;
  contestant.answers[i] = contestant.times.time(i, [&] {
    return contestant.engine->touching({question.steps[i], gate, left_out});
  });
}

bool contains(const std::vector<BodyPair>& pairs, const BodyPair& pair) {
  return std::binary_search(pairs.begin(), pairs.end(), pair);
}

/// Pairs of `of` that are not in `in`.
std::int64_t count_missing(const std::vector<BodyPair>& of, const std::vector<BodyPair>& in) {
  return std::count_if(of.begin(), of.end(), [&](const BodyPair& pair) { return !contains(in, pair); });
}

Answer summary(const Contestant& contestant, const PairQuestion& question) {
  Answer answer{contestant.front, contestant.times.mean_of_medians()};
  for (std::size_t i = 0; i < question.steps.size(); ++i) {
    answer.touching += static_cast<std::int64_t>(contestant.answers[i].size());
    answer.missed += count_missing(question.truth[i], contestant.answers[i]);
    answer.spurious += count_missing(contestant.answers[i], question.truth[i]);
  }
  return answer;
}

EngineResult summary(const std::vector<Contestant>& contestants, const PairQuestion& question) {
  EngineResult result;
  result.name = contestants.front().engine->name();
  for (const Contestant& contestant : contestants) {
    const Answer answer = summary(contestant, question);
    if (contestant.front.empty()) {
      result.alone = answer;
    } else if (contestant.front == perfect) {
      result.perfect_ms = answer.ms_per_step;
    } else {
      result.behind.push_back(answer);
    }
  }
  return result;
}

using Field = std::vector<std::vector<Contestant>>;  // per engine

void find_disagreements(const Field& field, const PairQuestion& question, std::size_t i,
                        std::vector<Disagreement>& disagreements) {
  std::vector<const Contestant*> asked;
  for (const std::vector<Contestant>& contestants : field) {
    for (const Contestant& c : contestants) {
      if (c.front != perfect) asked.push_back(&c);
    }
  }
  std::set<BodyPair> pairs(question.truth[i].begin(), question.truth[i].end());
  for (const Contestant* c : asked) pairs.insert(c->answers[i].begin(), c->answers[i].end());
  for (const BodyPair& pair : pairs) {
    Disagreement disagreement{question.steps[i].step, pair, contains(question.truth[i], pair), {}};
    for (const Contestant* c : asked) {
      if (contains(c->answers[i], pair)) disagreement.touching.push_back(c->name());
    }
    const std::size_t right =
        disagreement.truth ? disagreement.touching.size() : asked.size() - disagreement.touching.size();
    if (right < asked.size()) disagreements.push_back(std::move(disagreement));
  }
}

}  // namespace

Replay replay(const std::vector<std::unique_ptr<Engine>>& engines, const PairQuestion& question,
              const std::function<void(double fraction)>& progress) {
  Field field;
  for (const std::unique_ptr<Engine>& engine : engines) field.push_back(contestants_of(*engine, question));
  std::size_t contestants = 0, asked = 0;
  for (const std::vector<Contestant>& group : field) contestants += group.size();
  const double questions = static_cast<double>(contestants * question.steps.size()) * question.runs;

  for (const std::unique_ptr<Engine>& engine : engines) warm_up(*engine, question.steps);
  bench::in_turns(question.runs, question.steps.size(), [&](std::size_t first, std::size_t last) {
    for (std::vector<Contestant>& group : field) {
      for (Contestant& contestant : group) {
        for (std::size_t i = first; i < last; ++i) {
          ask(contestant, question, i);
          progress(static_cast<double>(++asked) / questions);
        }
      }
    }
  });

  Replay result;
  result.steps = static_cast<std::int64_t>(question.steps.size());
  for (const auto& pairs : question.left_out) result.left_out += static_cast<std::int64_t>(pairs.size());
  for (const auto& pairs : question.truth) result.touching += static_cast<std::int64_t>(pairs.size());
  for (const std::vector<Contestant>& group : field) result.engines.push_back(summary(group, question));
  for (std::size_t i = 0; i < question.steps.size(); ++i) {
    find_disagreements(field, question, i, result.disagreements);
  }
  return result;
}

}  // namespace encage::replay
