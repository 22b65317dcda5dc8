// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/tank/simulation_report.h"

#include "bench/common/report.h"
#include "bench/common/statistics.h"

namespace encage::tank {
namespace {

double per_step(std::int64_t sum, std::int64_t steps) {
  return bench::ratio(static_cast<double>(sum), static_cast<double>(steps));
}

double total(const CpuSeconds& cpu) { return cpu.boxes + cpu.pairs + cpu.walls + cpu.integration; }

}  // namespace

nlohmann::ordered_json to_json(const Simulation& simulation) {
  const Statistics& s = simulation.statistics;
  const auto steps = static_cast<std::int64_t>(s.energy.size());
  const Energy last = s.energy.empty() ? Energy{} : s.energy.back();
  return {{"steps", steps},
          {"body_steps", s.body_steps},
          {"held_body_steps", s.filter.held},
          {"most_held_in_a_step", s.most_held},
          {"passes_per_step", per_step(s.filter.passes, steps)},
          {"most_passes", s.most_passes},
          {"conflicts", s.filter.conflicts},
          {"pair_tests", s.filter.pair_tests},
          {"wall_tests", s.filter.wall_tests},
          {"energy",
           {{"entered", s.energy_entered},
            {"added", s.energy_added},
            {"lost_to_restitution", s.energy_lost},
            {"kinetic_at_end", last.kinetic},
            {"potential_at_end", last.potential},
            {"drift", s.energy_drift}}},
          {"cpu_seconds",
           {{"boxes", s.filter.cpu.boxes},
            {"pairs", s.filter.cpu.pairs},
            {"walls", s.filter.cpu.walls},
            {"integration", s.filter.cpu.integration},
            {"total", total(s.filter.cpu)}}}};
}

std::string to_text(const Simulation& simulation) {
  const Statistics& s = simulation.statistics;
  const auto steps = static_cast<std::int64_t>(s.energy.size());
  return bench::format(
      "simulated %lld steps: %.2f detections a step (%lld at most), %lld conflicts, %lld of %lld body-steps "
      "held\nenergy: %.6g entered, %.6g added, %.6g lost to restitution, drift %.2g; %.1f s CPU\n",
      static_cast<long long>(steps), per_step(s.filter.passes, steps), static_cast<long long>(s.most_passes),
      static_cast<long long>(s.filter.conflicts), static_cast<long long>(s.filter.held),
      static_cast<long long>(s.body_steps), s.energy_entered, s.energy_added, s.energy_lost, s.energy_drift,
      total(s.filter.cpu));
}

}  // namespace encage::tank
