// SPDX-License-Identifier: GPL-3.0-or-later
// encage-threads: the same searches with one thread and with several.

#include "bench/threads/steps.h"
#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"
#include "cagegen/cli/progress.h"

#include <encage/tbb_executor.h>

#include <CLI/CLI.hpp>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace encage::threads {
namespace {

constexpr const char* examples = R"(Examples:
  encage-threads --asset octopus.glb --poses bouncing.csv --every 10 --threads 1,2
      all pairs of octopuses in every tenth step in which all are there
  encage-threads --asset octopus.glb --poses bouncing.csv --every 100 --copies 28 --triangles
      28 such tanks at once, with the candidate triangles of each pair

Exit status: 0 if all numbers of threads gave the same, 1 if not, 2 for bad input or usage.)";

struct Arguments {
  std::filesystem::path asset, poses, json;
  std::vector<int> threads = {1, 2};
  StepsOptions steps;
  bool triangles = false;
  bool cages = false;
  int runs = 5;
};

void define(CLI::App& app, Arguments& a) {
  app.footer(examples);
  app.add_option("--asset", a.asset, "Asset of all bodies")->required()->type_name("FILE.glb");
  app.add_option("--poses", a.poses, "Poses of the bodies, step by step")->required()->type_name("FILE.csv");
  app.add_option("--threads", a.threads, "Numbers of threads, separated by commas; ratios are to the first")
      ->delimiter(',')
      ->check(CLI::Range(1, 1024).description(""))
      ->capture_default_str()
      ->type_name("N,...");
  app.add_option("--every", a.steps.every, "Take every K-th step only")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1'000'000'000}).description(""))
      ->type_name("K");
  app.add_option("--copies", a.steps.copies, "So many copies of all bodies side by side")
      ->check(CLI::Range(1, 100'000).description(""))
      ->type_name("N");
  app.add_flag("--continuous", a.steps.continuous, "Bodies move to their next poses; otherwise they rest");
  app.add_flag("--triangles", a.triangles, "Collect candidate triangles");
  app.add_flag("--cages", a.cages, "Ask cages before the fine meshes");
  app.add_option("--runs", a.runs, "Runs; the median time of each step counts")
      ->check(CLI::Range(1, 1000).description(""))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
}

/// One number of threads.
struct Contestant {
  int threads = 1;
  std::unique_ptr<oneapi::tbb::task_arena> arena;
  std::unique_ptr<Walker> walker;
  std::vector<std::vector<double>> updates, searches;  // milliseconds per step, of all runs
  double update_ms = 0, search_ms = 0;                 // means of medians
};

std::vector<Contestant> make_contestants(const Arguments& a, const ShapePtr& shape, const std::vector<Step>& steps) {
  std::vector<Contestant> all;
  for (const int threads : a.threads) {
    Contestant& c = all.emplace_back();
    c.threads = threads;
    CandidateOptions options;
    options.triangles = a.triangles;
    options.pair.cages = a.cages ? CageUse::always : CageUse::automatic;
    if (threads > 1) {
      c.arena = std::make_unique<oneapi::tbb::task_arena>(threads);
      options.executor = tbb_executor(*c.arena);
    }
    c.walker = std::make_unique<Walker>(shape, steps.front(), options);
    c.updates.resize(steps.size());
    c.searches.resize(steps.size());
  }
  return all;
}

/// Steps that did not give the same for all numbers of threads. Also warms up.
std::int64_t count_differences(std::vector<Contestant>& all, const std::vector<Step>& steps) {
  std::int64_t differences = 0;
  for (const Step& step : steps) {
    const Answer first = all.front().walker->walk_and_tell(step);
    bool same = true;
    for (std::size_t c = 1; c < all.size(); ++c) same = all[c].walker->walk_and_tell(step) == first && same;
    if (!same) ++differences;
  }
  return differences;
}

double mean_of_medians(std::vector<std::vector<double>>& runs) {
  double sum = 0;
  for (std::vector<double>& times : runs) {
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    sum += *middle;
  }
  return sum / static_cast<double>(runs.size());
}

/// Numbers of threads take turns, a run each.
void measure(std::vector<Contestant>& all, const std::vector<Step>& steps, int runs) {
  tool::Progress progress = tool::Progress::on_stderr();
  const auto total = static_cast<double>(all.size()) * runs;
  int done = 0;
  for (int run = 0; run < runs; ++run) {
    for (Contestant& c : all) {
      for (std::size_t i = 0; i < steps.size(); ++i) {
        const StepTime time = c.walker->walk(steps[i]);
        c.updates[i].push_back(time.update);
        c.searches[i].push_back(time.search);
      }
      tool::throw_if_interrupted();
      progress.update(++done / total, "searching");
    }
  }
  for (Contestant& c : all) {
    c.update_ms = mean_of_medians(c.updates);
    c.search_ms = mean_of_medians(c.searches);
  }
}

nlohmann::ordered_json to_json(const Arguments& a, const std::vector<Contestant>& all, std::size_t bodies,
                               std::size_t steps, std::int64_t differences) {
  nlohmann::ordered_json json = {{"asset", a.asset.string()},
                                 {"poses", a.poses.string()},
                                 {"bodies", bodies},
                                 {"steps", steps},
                                 {"continuous", a.steps.continuous},
                                 {"triangles", a.triangles},
                                 {"threads", nlohmann::ordered_json::array()}};
  for (const Contestant& c : all) {
    json["threads"].push_back({{"threads", c.threads},
                               {"update_ms_per_step", c.update_ms},
                               {"search_ms_per_step", c.search_ms},
                               {"search_ratio", all.front().search_ms / c.search_ms}});
  }
  json["different_steps"] = differences;
  return json;
}

void print(const std::vector<Contestant>& all, std::size_t bodies, std::size_t steps, std::int64_t differences) {
  std::cout << bodies << " bodies, " << steps << " steps, milliseconds of wall clock per step\n\n"
            << "threads     update     search    ratio    ratio of the sum\n";
  for (const Contestant& c : all) {
    std::array<char, 128> line;
    const Contestant& one = all.front();
    std::snprintf(line.data(), line.size(), "%7d %10.4f %10.4f %8.3f %19.3f\n", c.threads, c.update_ms, c.search_ms,
                  one.search_ms / c.search_ms, (one.update_ms + one.search_ms) / (c.update_ms + c.search_ms));
    std::cout << line.data();
  }
  if (differences == 0) {
    std::cout << "\nThe same results in the same order.\n";
  } else {
    std::cerr << "encage-threads: results differ in " << differences << " steps\n";
  }
}

int run(const Arguments& a) {
  const tool::InterruptScope scope;
  for (const auto& read : {a.asset, a.poses}) {
    if (!a.json.empty()) tool::check_output(a.json, read);
  }
  namespace tbb = oneapi::tbb;
  const auto most = static_cast<std::size_t>(*std::max_element(a.threads.begin(), a.threads.end()));
  const tbb::global_control enough_threads(tbb::global_control::max_allowed_parallelism, most);
  const ShapePtr shape = load_shape(a.asset);
  const std::vector<Step> steps = make_steps(read_poses(a.poses), *shape, a.steps);
  std::vector<Contestant> all = make_contestants(a, shape, steps);
  const std::int64_t differences = count_differences(all, steps);
  measure(all, steps, a.runs);
  const std::size_t bodies = steps.front().size();
  if (!a.json.empty()) tool::write_json(a.json, to_json(a, all, bodies, steps.size(), differences));
  print(all, bodies, steps.size(), differences);
  return differences == 0 ? tool::success : tool::answer_is_no;
}

}  // namespace
}  // namespace encage::threads

int main(int argc, char** argv) {
  CLI::App app("Searches worlds of many bodies with one thread and with several: the same results, how fast?",
               "encage-threads");
  encage::threads::Arguments a;
  encage::threads::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::threads::run(a); });
}
