// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/micro/workload.h"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <string>

namespace encage::micro {

// Registers the benches; the workload has to outlive them. Names are stable: kernel/, stage/, load/, refit/ and field/.
void add_kernels(const Workload& workload);
void add_gates(const Workload& workload);
void add_stages(const Workload& workload);
void add_worlds(const Workload& workload);
void add_loads(const Workload& workload);
void add_refits(const Workload& workload);
void add_fields();

/// Asks `question` about one item after the other, round and round; counts items. What it answers is kept.
template <class Items, class Question>
void ask_in_turn(benchmark::State& state, const Items& items, const Question& question) {
  if (items.empty()) {
    state.SkipWithError("no such input");
    return;
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(question(items[i]));
    if (++i == items.size()) i = 0;
  }
  state.SetItemsProcessed(state.iterations());
}

/// A bench that does.
template <class Items, class Question>
void add(const std::string& name, const Items& items, Question question) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [&items, question](benchmark::State& state) { ask_in_turn(state, items, question); });
}

}  // namespace encage::micro
