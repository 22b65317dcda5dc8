// SPDX-License-Identifier: GPL-3.0-or-later
// encage-assets: many assets, of which few come near each other, kept in memory whole or on demand.

#include "bench/assets/make_assets.h"
#include "bench/assets/measure.h"
#include "bench/zoo/isolated.h"
#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"
#include "cagegen/cli/progress.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace encage::assets {
namespace {

constexpr const char* examples = R"(Examples:
  encage-assets /tmp/assets
      makes 2,000 assets there (5.4 GB), unless they are there, and measures
  encage-assets /tmp/assets --count 100 --budget-mib 16 --steps 50 --runs 1

JSON: assets {count, file_bytes, triangles}; ways[], each the medians of its runs of load_ms, first_answer_ms,
step_ms (mean of the steps after the first), step_ms_median, step_ms_worst, resident_bytes (the most while it ran;
anonymous_bytes and file_bytes are its parts), near_pairs_per_step (boxes not apart), candidates_per_step, answers (a
hash), and of a cache budget_bytes, fine_peak_bytes, faults, evictions; equal: whether all ways gave the same.

Exit status: 0 if all ways gave the same candidates and triangles, 1 if not, 2 for bad input or usage.)";

struct Arguments {
  std::filesystem::path folder, json;
  AssetOptions assets;
  int runs = 3;
  int budget_mib = 96;
  MeasureOptions measure;
};

void define(CLI::App& app, Arguments& a) {
  app.footer(examples);
  app.add_option("folder", a.folder, "Where assets are made and found")->required()->type_name("FOLDER");
  app.add_option("--count", a.assets.count, "Number of assets, and of bodies")
      ->check(CLI::Range(2, 5000).description(""))
      ->capture_default_str();
  app.add_option("--bases", a.assets.bases, "Assets to bake; the others are turned, mirrored and scaled")
      ->check(CLI::Range(1, 1000).description(""))
      ->capture_default_str();
  app.add_option("--triangles", a.assets.triangles, "Of a mesh, about")
      ->check(CLI::Range(200, 1'000'000).description(""))
      ->capture_default_str();
  app.add_option("--budget-mib", a.budget_mib, "For fine meshes on demand")
      ->check(CLI::Range(1, 1 << 20).description(""))
      ->capture_default_str();
  app.add_option("--steps", a.measure.steps, "Steps of the scene")
      ->check(CLI::Range(2, 1'000'000).description(""))
      ->capture_default_str();
  app.add_option("--spacing", a.measure.scene.spacing, "Edge of the cube that a body has for itself on average")
      ->check(CLI::Range(0.1, 100.0).description(""))
      ->capture_default_str();
  app.add_option("--runs", a.runs, "Runs; medians count")
      ->check(CLI::Range(1, 100).description(""))
      ->capture_default_str();
  app.add_flag("--cold", a.measure.cold, "Let the system forget the files before each run");
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
}

nlohmann::ordered_json isolated(const std::function<nlohmann::ordered_json()>& work) {
  const zoo::ChildResult result = zoo::run_isolated([&] { return work().dump(); });
  tool::throw_if_interrupted();
  if (!result.error.empty()) throw Error(result.error);
  return nlohmann::ordered_json::parse(result.output);
}

/// Medians of numbers; what is no number is the same in all runs, or said so.
nlohmann::ordered_json median(const std::vector<nlohmann::ordered_json>& runs) {
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
  std::printf("%d assets, %.2f GB, %.1f million triangles; %.1f pairs near and %.1f candidates per step\n\n",
              json["assets"]["count"].get<int>(), json["assets"]["file_bytes"].get<double>() / 1e9,
              json["assets"]["triangles"].get<double>() / 1e6, ways[0]["near_pairs_per_step"].get<double>(),
              ways[0]["candidates_per_step"].get<double>());
  std::printf("%-24s %12s %10s %10s %12s %10s %10s %10s %8s\n", "", "resident MB", "anonymous", "file", "first ms",
              "step ms", "median", "worst", "faults");
  for (const auto& way : ways) {
    const auto mb = [&](const char* key) { return way[key].get<double>() / 1e6; };
    const auto ms = [&](const char* key) { return way[key].get<double>(); };
    std::printf("%-24s %12.1f %10.1f %10.1f %12.1f %10.3f %10.3f %10.3f %8lld\n",
                way["name"].get<std::string>().c_str(), mb("resident_bytes"), mb("anonymous_bytes"), mb("file_bytes"),
                ms("first_answer_ms"), ms("step_ms"), ms("step_ms_median"), ms("step_ms_worst"),
                way.value("faults", 0LL));
  }
}

int run(Arguments a) {
  if (!a.json.empty()) tool::check_output(a.json, a.folder);
  const tool::InterruptScope scope;
  a.measure.scene.bodies = a.assets.count;
  // In children of their own: making assets leaves threads and memory behind.
  isolated([&]() -> nlohmann::ordered_json {
    tool::Progress progress = tool::Progress::on_stderr();
    make_assets(a.folder, a.assets, progress.context(&tool::interrupted));
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
      runs[w].push_back(isolated([&] { return measure(ways[w], found.files, a.measure); }));
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
    json["ways"].push_back(median(of_way));
    for (const auto& one : of_way) equal = equal && one["answers"] == runs[0][0]["answers"];
  }
  json["equal"] = equal;
  if (!a.json.empty()) tool::write_json(a.json, json);
  print(json);
  if (!equal) std::cerr << "encage-assets: candidates differ\n";
  return equal ? tool::success : tool::answer_is_no;
}

}  // namespace
}  // namespace encage::assets

int main(int argc, char** argv) {
  CLI::App app("Keeps many assets in memory, or only what is needed of them: how much memory, how fast?",
               "encage-assets");
  encage::assets::Arguments a;
  encage::assets::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::assets::run(a); });
}
