// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/measurement_report.h"

#include "bench/common/report.h"

#include <array>

namespace encage::tank {
namespace {

using Json = nlohmann::ordered_json;

double per_step(std::int64_t sum, std::int64_t steps) {
  return steps > 0 ? static_cast<double>(sum) / static_cast<double>(steps) : 0;
}

/// A speed-up, named by its key and explained by a sentence.
struct Speedup {
  const char* key;
  const char* slow;
  const char* fast;
  const char* meaning;
};

constexpr std::array<Speedup, 7> speedups = {{
    {"speedup_paper", "rebuild_kdop", "rebuild_kdop+cages", "cages, where 26-DOP trees are rebuilt (the paper's)"},
    {"speedup_embree", "rebuild_embree", "rebuild_embree+cages", "cages, where Embree rebuilds its trees"},
    {"speedup_prebuilt", "prebuilt", "prebuilt+cages", "cages, where trees are built once"},
    {"speedup_policy", "prebuilt", "prebuilt+policy", "the default: cages where trees are not there"},
    {"prebuilt_over_kdop", "rebuild_kdop", "prebuilt", "trees built once instead of 26-DOP trees rebuilt"},
    {"prebuilt_over_embree", "rebuild_embree", "prebuilt", "trees built once instead of Embree's rebuilt"},
    {"prebuilt_over_embree_cages", "rebuild_embree+cages", "prebuilt", "the same, against Embree's behind cages"},
}};

Json to_json(const StrategyResult& r, std::int64_t steps) {
  return {{"detect_ms_per_step", r.ms_per_step},
          {"steps_timed", r.steps_timed},
          {"sampled_ms_per_step", r.sampled_ms},
          {"bodies_rebuilt_per_step", r.rebuilds ? per_step(r.bodies, steps) : 0},
          {"bodies_left_per_step", per_step(r.bodies, steps)},
          {"pairs_per_step", per_step(r.counts.pairs, r.steps_timed)},
          {"rejects_by_stage",
           {{"boxes", per_step(r.counts.pairs - r.counts.boxes, r.steps_timed)},
            {"cages", per_step(r.counts.boxes - r.counts.cages, r.steps_timed)},
            {"triangles", per_step(r.counts.cages - r.counts.touching, r.steps_timed)}}},
          {"touching_per_step", per_step(r.counts.touching, r.steps_timed)},
          {"missed_contacts", r.faults.missed},
          {"spurious", r.faults.spurious}};
}

std::string table(const Measurement& m) {
  std::string text = bench::format("%-21s %11s %7s %9s %7s %7s %9s %7s\n", "strategy (one thread)", "ms/step", "steps",
                                   "rebuilt", "boxes", "cages", "touching", "wrong");
  for (const StrategyResult& r : m.strategies) {
    const auto mean = [&](std::int64_t sum) { return per_step(sum, r.steps_timed); };
    text += bench::format("%-21s %11.3f %7lld %9.3f %7.3f %7.3f %9.4f %7lld\n", r.name.c_str(), r.ms_per_step,
                          static_cast<long long>(r.steps_timed), r.rebuilds ? per_step(r.bodies, m.steps) : 0,
                          mean(r.counts.boxes), mean(r.counts.cages), mean(r.counts.touching),
                          static_cast<long long>(r.faults.missed + r.faults.spurious));
  }
  return text +
         "rebuilt: bodies whose tree is built, mean over all steps; boxes, cages, touching: pairs left after\n"
         "the stage, mean over the steps timed; wrong: contacts missed or spurious\n";
}

}  // namespace

Json to_json(const Measurement& m) {
  Json json = {{"steps", m.steps}, {"sampled_steps", m.sampled_steps}, {"left_out_pairs", m.left_out}};
  for (const StrategyResult& r : m.strategies) json["strategies"][r.name] = to_json(r, m.steps);
  json["pairs_left_per_step"] = {{"all", per_step(m.counts.pairs, m.steps)},
                                 {"boxes", per_step(m.counts.boxes, m.steps)},
                                 {"cages", per_step(m.counts.cages, m.steps)},
                                 {"touching", per_step(m.counts.touching, m.steps)}};
  json["oracle_bodies_per_step"] = per_step(m.oracle_bodies, m.steps);
  if (m.sampled_steps > 0) {
    for (const Speedup& s : speedups) json[s.key] = m.speedup(s.slow, s.fast);
  }
  json["speedup_count"] = m.speedup_count();
  json["missed_contacts"] = m.faults().missed;
  json["spurious"] = m.faults().spurious;
  return json;
}

std::string to_text(const Measurement& m) {
  std::string text = table(m) + '\n';
  if (m.sampled_steps > 0) {
    text += bench::format("speed-ups, on the same %lld steps:\n", static_cast<long long>(m.sampled_steps));
    for (const Speedup& s : speedups) {
      text += bench::format("%10.3f  %s / %s: %s\n", m.speedup(s.slow, s.fast), s.slow, s.fast, s.meaning);
    }
  }
  text += bench::format(
      "%10.3f  bodies rebuilt without / with cages, over all %lld steps: %.3f / %.3f; an oracle: %.3f\n",
      m.speedup_count(), static_cast<long long>(m.steps), per_step(m.strategy("prebuilt").bodies, m.steps),
      per_step(m.strategy("prebuilt+cages").bodies, m.steps), per_step(m.oracle_bodies, m.steps));
  if (m.left_out > 0) {
    text += bench::format("left out: %lld times a pair that is not proven apart where a step begins\n",
                          static_cast<long long>(m.left_out));
  }
  return text;
}

}  // namespace encage::tank
