// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench assets: many assets, of which few come near each other, kept in memory whole or on demand.

#include "bench/common/process.h"
#include "bench/common/report.h"
#include "bench/common/watch.h"
#include "bench/suite/assets/make_assets.h"
#include "bench/suite/assets/measure.h"
#include "bench/suite/commands.h"
#include "cagegen/cli/output_file.h"

#include <encage/error.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

namespace encage::assets {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bench assets /tmp/assets
      makes 2,000 assets there (5.4 GB), unless they are there, and measures
  encage-bench assets /tmp/assets --count 100 --budget-mib 16 --steps 50 --runs 1

JSON: assets {count, file_bytes, triangles}; ways[], each the medians of its runs of load_ms, first_answer_ms,
step_ms (mean of the steps after the first), step_ms_median, step_ms_worst, resident_bytes (the most while it ran;
anonymous_bytes and file_bytes are its parts), near_pairs_per_step (boxes not apart), candidates_per_step, answers (a
hash), and of a cache budget_bytes, fine_peak_bytes, faults, evictions; equal: whether all ways gave the same.

Exit status: 0 if all ways gave the same candidates and triangles, 1 if not, 2 for bad input or usage.)";

struct AssetsArguments {
  std::filesystem::path folder, json;
  AssetOptions assets;
  int runs = 3;
  int budget_mib = 96;
  AssetRunOptions measure;
};

void define(bench::CommandOptions& options, AssetsArguments& a) {
  options.add("folder", a.folder, "Where assets are made and found").required().type("FOLDER");
  options.add("--count", a.assets.count, "Number of assets, and of bodies").between(2, 5000).shows_default();
  options.add("--bases", a.assets.bases, "Assets to bake; the others are turned, mirrored and scaled")
      .between(1, 1000)
      .shows_default();
  options.add("--triangles", a.assets.triangles, "Of a mesh, about").between(200, 1'000'000).shows_default();
  options.add("--budget-mib", a.budget_mib, "For fine meshes on demand").between(1, 1 << 20).shows_default();
  options.steps(a.measure.steps, "Steps of the scene");
  options.add("--spacing", a.measure.scene.spacing, "Edge of the cube that a body has for itself on average")
      .within(0.1, 100)
      .shows_default();
  options.runs(a.runs, "Runs; medians count");
  options.flag("--cold", a.measure.cold, "Let the system forget the files before each run");
  options.json(a.json);
}

nlohmann::ordered_json isolated(const std::function<nlohmann::ordered_json()>& work) {
  const bench::ChildResult result = bench::run_isolated([&] { return work().dump(); });
  tool::throw_if_interrupted();
  if (!result.error.empty()) throw Error(result.error);
  return nlohmann::ordered_json::parse(result.output);
}

/// Of every number one that was measured, the median; what is no number is the same in all runs, or said so.
nlohmann::ordered_json median_run(const std::vector<nlohmann::ordered_json>& runs) {
  nlohmann::ordered_json result = runs.front();
  for (auto& [key, value] : result.items()) {
    if (!value.is_number()) continue;
    std::vector<nlohmann::ordered_json> values;
    for (const auto& run : runs) values.push_back(run.at(key));
    std::sort(values.begin(), values.end());
    value = values[values.size() / 2];
  }
  return result;
}

void print(const nlohmann::ordered_json& json) {
  const auto& ways = json["ways"];
  std::cout << bench::format(
                   "%d assets, %.2f GB, %.1f million triangles; %.1f pairs near and %.1f candidates per step\n\n",
                   json["assets"]["count"].get<int>(), json["assets"]["file_bytes"].get<double>() / 1e9,
                   json["assets"]["triangles"].get<double>() / 1e6, ways[0]["near_pairs_per_step"].get<double>(),
                   ways[0]["candidates_per_step"].get<double>())
            << bench::format("%-24s %12s %10s %10s %12s %10s %10s %10s %8s\n", "", "resident MB", "anonymous", "file",
                             "first ms", "step ms", "median", "worst", "faults");
  for (const auto& way : ways) {
    const auto mb = [&](const char* key) { return way[key].get<double>() / 1e6; };
    const auto ms = [&](const char* key) { return way[key].get<double>(); };
    std::cout << bench::format("%-24s %12.1f %10.1f %10.1f %12.1f %10.3f %10.3f %10.3f %8lld\n",
                               way["name"].get<std::string>().c_str(), mb("resident_bytes"), mb("anonymous_bytes"),
                               mb("file_bytes"), ms("first_answer_ms"), ms("step_ms"), ms("step_ms_median"),
                               ms("step_ms_worst"), way.value("faults", 0LL));
  }
}

bool run(AssetsArguments& a) {
  bench::check_outputs({a.json}, {a.folder});
  bench::Watch watch;
  a.measure.scene.bodies = a.assets.count;
  // In children of their own: making assets leaves threads and memory behind.
  isolated([&]() -> nlohmann::ordered_json {
    make_assets(a.folder, a.assets, watch.context());
    return {};
  });
  const AssetFiles found = find_assets(a.folder, a.assets);
  const std::int64_t budget = std::int64_t{a.budget_mib} << 20;
  const std::array<Way, 4> ways = {{{"all in memory, mapped", LoadMode::map, 0},
                                    {"all in memory, copied", LoadMode::copy, 0},
                                    {"on demand, mapped", LoadMode::map, budget},
                                    {"on demand, copied", LoadMode::copy, budget}}};
  std::array<std::vector<nlohmann::ordered_json>, 4> runs;
  for (int i = 0; i < a.runs; ++i) {
    for (std::size_t w = 0; w < ways.size(); ++w) {
      runs[w].push_back(isolated([&] { return run_way(ways[w], found.files, a.measure); }));
    }
  }
  nlohmann::ordered_json json = {{"assets",
                                  {{"count", a.assets.count},
                                   {"bases", a.assets.bases},
                                   {"file_bytes", found.bytes},
                                   {"triangles", found.triangles}}},
                                 {"cold", a.measure.cold},
                                 {"steps", a.measure.steps},
                                 {"spacing", a.measure.scene.spacing},
                                 {"ways", nlohmann::ordered_json::array()}};
  bool equal = true;
  for (const auto& of_way : runs) {
    json["ways"].push_back(median_run(of_way));
    for (const auto& one : of_way) equal = equal && one["answers"] == runs[0][0]["answers"];
  }
  json["equal"] = equal;
  if (!a.json.empty()) tool::write_json(a.json, json);
  print(json);
  if (!equal) std::cerr << "encage-bench assets: candidates differ\n";
  return equal;
}

}  // namespace

bench::Command command() {
  return bench::make_command<AssetsArguments>(
      "assets", "Keeps many assets in memory, or only what is needed of them: how much memory, how fast?", examples,
      define, run);
}

}  // namespace encage::assets
