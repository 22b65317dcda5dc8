// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/micro/benches.h"

#include <encage/asset.h>

namespace encage::micro {

void add_loads(const Workload& w) {
  // Items are triangles.
  const auto count = [](const CageHierarchy& h) {
    std::int64_t triangles = h.fine.triangles.rows();
    for (const CageLevel& level : h.levels) triangles += level.mesh.triangles.rows();
    return triangles;
  };
  benchmark::RegisterBenchmark("load/load_shape", [&w, count](benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(load_shape(w.asset));
    state.SetItemsProcessed(state.iterations() * count(read_asset(w.asset)));
  })->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("load/make_shape", [&w, count](benchmark::State& state) {
    const CageHierarchy hierarchy = read_asset(w.asset);
    for (auto _ : state) benchmark::DoNotOptimize(make_shape(hierarchy));
    state.SetItemsProcessed(state.iterations() * count(hierarchy));
  })->Unit(benchmark::kMillisecond);
}

}  // namespace encage::micro
