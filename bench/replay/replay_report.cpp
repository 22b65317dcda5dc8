// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/replay_report.h"

#include "bench/common/report.h"
#include "bench/common/statistics.h"

#include <algorithm>
#include <string>
#include <vector>

namespace encage::replay {
namespace {

std::string milliseconds(double value) { return bench::format("%.3f", value); }
std::string times(double value) { return bench::format("%.2f", value); }

const Answer* find(const EngineResult& engine, const std::string& front) {
  const auto at = std::find_if(engine.behind.begin(), engine.behind.end(),
                               [&](const Answer& answer) { return answer.front == front; });
  return at == engine.behind.end() ? nullptr : &*at;
}

std::vector<std::string> fronts_of(const Replay& replay) {
  std::vector<std::string> fronts;
  for (const EngineResult& engine : replay.engines) {
    for (const Answer& answer : engine.behind) {
      if (std::find(fronts.begin(), fronts.end(), answer.front) == fronts.end()) fronts.push_back(answer.front);
    }
  }
  return fronts;
}

/// Of Encage alone; 0 if it was not asked.
double encage_ms(const Replay& replay) {
  for (const EngineResult& engine : replay.engines) {
    if (engine.name == "encage") return engine.alone.ms_per_step;
  }
  return 0;
}

nlohmann::ordered_json to_json(const Answer& answer) {
  return {{"ms_per_step", answer.ms_per_step},
          {"touching_pairs", answer.touching},
          {"missed", answer.missed},
          {"spurious", answer.spurious}};
}

nlohmann::ordered_json to_json(const Continuous& c) {
  return {{"steps", c.steps},
          {"ms_per_step", c.ms_per_step},
          {"discrete_ms_per_step", c.discrete_ms_per_step},
          {"ratio", bench::ratio(c.ms_per_step, c.discrete_ms_per_step)},
          {"pairs_left_out", c.left_out},
          {"pairs_asked", c.asked},
          {"pairs_not_separated", c.survivors},
          {"contacts", c.contacts}};
}

void print_continuous(std::ostream& out, const Continuous& c) {
  out << "\nContinuous, Encage, " << c.steps << " steps: " << milliseconds(c.ms_per_step)
      << " ms/step with narrow phase, " << milliseconds(c.discrete_ms_per_step) << " discrete, ratio "
      << times(bench::ratio(c.ms_per_step, c.discrete_ms_per_step)) << "; " << c.asked << " pairs, " << c.survivors
      << " not proven separated, " << c.contacts << " contacts; left out, as they touch at the start: " << c.left_out
      << " pairs\n";
}

}  // namespace

nlohmann::ordered_json to_json(const Replay& replay, const std::optional<Continuous>& continuous) {
  nlohmann::ordered_json json = {
      {"steps", replay.steps}, {"touching_pairs", replay.touching}, {"pairs_left_out", replay.left_out}};
  for (const EngineResult& engine : replay.engines) {
    json["engines"][engine.name] = to_json(engine.alone);
    for (const Answer& answer : engine.behind) {
      nlohmann::ordered_json& entry = json["with_" + answer.front][engine.name] = to_json(answer);
      entry["speedup"] = bench::ratio(engine.alone.ms_per_step, answer.ms_per_step);
    }
    json["perfect"][engine.name] = {{"ms_per_step", engine.perfect_ms},
                                    {"speedup", bench::ratio(engine.alone.ms_per_step, engine.perfect_ms)}};
  }
  if (continuous) json["continuous"] = to_json(*continuous);
  json["disagreements"] = replay.disagreements.size();
  json["disagreeing_pairs"] = nlohmann::ordered_json::array();
  for (const Disagreement& d : replay.disagreements) {
    json["disagreeing_pairs"].push_back(
        {{"step", d.step}, {"body_a", d.pair.a}, {"body_b", d.pair.b}, {"truth", d.truth}, {"touching", d.touching}});
  }
  return json;
}

void print(std::ostream& out, const Replay& replay, const std::optional<Continuous>& continuous) {
  const std::vector<std::string> fronts = fronts_of(replay);
  std::vector<std::string> head = {"engine", "ms/step", "/ Encage"};
  for (const std::string& front : fronts) head.insert(head.end(), {"with " + front, "gain"});
  head.insert(head.end(), {"perfect", "bound", "touching", "missed", "spurious"});
  bench::MarkdownTable table(out, head, 16, 12);
  const double reference = encage_ms(replay);
  for (const EngineResult& engine : replay.engines) {
    const double alone = engine.alone.ms_per_step;
    std::vector<std::string> row = {engine.name, milliseconds(alone),
                                    reference > 0 ? times(bench::ratio(alone, reference)) : "-"};
    for (const std::string& front : fronts) {
      const Answer* answer = find(engine, front);
      row.push_back(answer ? milliseconds(answer->ms_per_step) : "-");
      row.push_back(answer ? times(bench::ratio(alone, answer->ms_per_step)) : "-");
    }
    row.insert(row.end(), {milliseconds(engine.perfect_ms), times(bench::ratio(alone, engine.perfect_ms)),
                           std::to_string(engine.alone.touching), std::to_string(engine.alone.missed),
                           std::to_string(engine.alone.spurious)});
    table.row(row);
  }
  out << "\nTruly touching: " << replay.touching << " pairs; left out: " << replay.left_out
      << " pairs; pairs about which somebody is wrong: " << replay.disagreements.size() << '\n';
  if (continuous) print_continuous(out, *continuous);
}

void print(std::ostream& out, const std::string& prefix, const std::vector<Disagreement>& disagreements) {
  for (const Disagreement& d : disagreements) {
    out << prefix << "step " << d.step << ", bodies " << d.pair.a << " and " << d.pair.b
        << (d.truth ? " touch, but only by" : " do not touch, but by");
    for (const std::string& name : d.touching) out << ' ' << name;
    out << (d.touching.empty() ? " none\n" : "\n");
  }
}

}  // namespace encage::replay
