// SPDX-License-Identifier: GPL-3.0-or-later
// encage-micro: what each kernel and each stage costs, alone.

#include "bench/micro/benches.h"
#include "cagegen/cli/program.h"

#include <encage/error.h>

#include <CLI/CLI.hpp>
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

struct Arguments {
  std::filesystem::path asset, poses;
};

int run(const Arguments& a) {
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
  if (benchmark::RunSpecifiedBenchmarks() == 0) throw Error("no bench of that name");
  benchmark::Shutdown();
  return tool::success;
}

}  // namespace
}  // namespace encage::micro

int main(int argc, char** argv) {
  // Google Benchmark takes its own options out.
  benchmark::Initialize(&argc, argv);
  CLI::App app("What each kernel and each stage of the run time costs, alone.", "encage-micro");
  encage::micro::Arguments a;
  app.footer(encage::micro::examples);
  app.add_option("--asset", a.asset, "Asset of all bodies; without, a small torus")
      ->envname("ENCAGE_MICRO_ASSET")
      ->type_name("FILE.glb");
  app.add_option("--poses", a.poses, "Poses of the bodies, step by step")
      ->envname("ENCAGE_MICRO_POSES")
      ->type_name("FILE.csv");
  return encage::tool::run_program(app, argc, argv, [&] { return encage::micro::run(a); });
}
