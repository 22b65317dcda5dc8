// SPDX-License-Identifier: GPL-3.0-or-later
// encage-micro: what each kernel and each stage costs, alone.

#include "bench/common/command.h"
#include "bench/micro/benches.h"

#include <encage/error.h>

#include <benchmark/benchmark.h>

#include <filesystem>
#include <string>

namespace encage::micro {
namespace {

constexpr const char* examples = R"(Examples:
  encage-micro --benchmark_filter=kernel/
      on a torus of 8,192 triangles
  encage-micro --asset octopus.glb --poses bouncing.csv --benchmark_out=micro.json
      on bodies of an asset in recorded steps

Exit status: 0 success, 2 bad input or usage. --benchmark_... are Google Benchmark's options.)";

struct MicroArguments {
  std::filesystem::path asset, poses;
};

bool run(MicroArguments& a) {
  if (a.asset.empty() != a.poses.empty()) throw Error("--asset and --poses belong together");
  const Workload workload = a.asset.empty() ? sample_workload() : recorded_workload(a.asset, a.poses);
  benchmark::AddCustomContext("shape", a.asset.empty() ? "torus" : a.asset.filename().string());
  benchmark::AddCustomContext("poses", a.poses.empty() ? "random" : a.poses.filename().string());
  benchmark::AddCustomContext("pairs", std::to_string(workload.cases.size()));
  add_kernels(workload);
  add_gates(workload);
  add_stages(workload);
  add_worlds(workload);
  add_loads(workload);
  add_refits(workload);
  add_fields();
  if (benchmark::RunSpecifiedBenchmarks() == 0) throw Error("no bench of that name");
  benchmark::Shutdown();
  return true;
}

void define(bench::CommandOptions& options, MicroArguments& a) {
  options.asset(a.asset, "Asset of all bodies; without, a small torus").environment("ENCAGE_MICRO_ASSET");
  options.add("--poses", a.poses, "Poses of the bodies, step by step")
      .environment("ENCAGE_MICRO_POSES")
      .type("FILE.csv");
}

}  // namespace
}  // namespace encage::micro

int main(int argc, char** argv) {
  // Google Benchmark takes its own options out.
  benchmark::Initialize(&argc, argv);
  using namespace encage;
  return bench::run_command(bench::make_command<micro::MicroArguments>(
                                "encage-micro", "What each kernel and each stage of the run time costs, alone.",
                                micro::examples, micro::define, micro::run),
                            argc, argv);
}
