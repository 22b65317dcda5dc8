// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench threads: the same searches with one thread and with several.

#include "bench/common/clock.h"
#include "bench/common/report.h"
#include "bench/common/step_times.h"
#include "bench/common/watch.h"
#include "bench/suite/commands.h"
#include "bench/suite/threads/steps.h"
#include "cagegen/cli/output_file.h"

#include <encage/tbb_executor.h>

#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace encage::threads {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bench threads --asset octopus.glb --poses bouncing.csv --every 10 --threads 1,2
      all pairs of octopuses in every tenth step in which all are there
  encage-bench threads --asset octopus.glb --poses bouncing.csv --every 100 --copies 28 --triangles
      28 such tanks at once, with the candidate triangles of each pair

Exit status: 0 if all numbers of threads gave the same, 1 if not, 2 for bad input or usage.)";

struct ThreadsArguments {
  std::filesystem::path asset, poses, json;
  std::vector<int> threads = {1, 2};
  StepsOptions steps;
  bool triangles = false;
  bool cages = false;
  int runs = 5;
};

void define(bench::CommandOptions& options, ThreadsArguments& a) {
  options.asset(a.asset).required();
  options.poses(a.poses);
  options.add("--threads", a.threads, "Numbers of threads, separated by commas; ratios are to the first")
      .between(1, 1024)
      .shows_default()
      .type("N,...");
  options.every(a.steps.every);
  options.add("--copies", a.steps.copies, "So many copies of all bodies side by side").between(1, 100'000).type("N");
  options.flag("--continuous", a.steps.continuous, "Bodies move to their next poses; otherwise they rest");
  options.flag("--triangles", a.triangles, "Collect candidate triangles");
  options.flag("--cages", a.cages, "Ask cages before the fine meshes");
  options.runs(a.runs, "Runs; the median time of each step counts");
  options.json(a.json);
}

/// One number of threads.
struct Crew {
  int threads = 1;
  std::unique_ptr<oneapi::tbb::task_arena> arena;
  std::unique_ptr<Walker> walker;
  bench::StepTimes updates, searches;
  double update_ms = 0, search_ms = 0;  // means of medians
};

std::vector<Crew> make_contestants(const ThreadsArguments& a, const ShapePtr& shape,
                                   const std::vector<WorldStep>& steps) {
  std::vector<Crew> all;
  for (const int threads : a.threads) {
    Crew& c = all.emplace_back(
        Crew{threads, nullptr, nullptr, bench::StepTimes(steps.size()), bench::StepTimes(steps.size())});
    CandidateOptions options;
    options.triangles = a.triangles;
    options.pair.cages = a.cages ? CageUse::always : CageUse::automatic;
    if (threads > 1) {
      c.arena = std::make_unique<oneapi::tbb::task_arena>(threads);
      options.executor = tbb_executor(*c.arena);
    }
    c.walker = std::make_unique<Walker>(shape, steps.front(), options);
  }
  return all;
}

/// Steps that did not give the same for all numbers of threads. Also warms up.
std::int64_t count_differences(std::vector<Crew>& all, const std::vector<WorldStep>& steps) {
  std::int64_t differences = 0;
  for (const WorldStep& step : steps) {
    const SearchResult first = all.front().walker->walk_and_tell(step);
    bool same = true;
    for (std::size_t c = 1; c < all.size(); ++c) same = all[c].walker->walk_and_tell(step) == first && same;
    if (!same) ++differences;
  }
  return differences;
}

/// Numbers of threads take turns, a run each.
void measure(std::vector<Crew>& all, const std::vector<WorldStep>& steps, int runs, bench::Watch& watch) {
  const auto total = static_cast<double>(all.size()) * runs;
  int done = 0;
  for (int run = 0; run < runs; ++run) {
    for (Crew& c : all) {
      for (std::size_t i = 0; i < steps.size(); ++i) {
        const StepTime time = c.walker->walk(steps[i]);
        c.updates.add(i, time.update);
        c.searches.add(i, time.search);
      }
      watch.report(++done / total, "searching");
    }
  }
  for (Crew& c : all) {
    c.update_ms = c.updates.mean_of_medians();
    c.search_ms = c.searches.mean_of_medians();
  }
}

nlohmann::ordered_json to_json(const ThreadsArguments& a, const std::vector<Crew>& all, std::size_t bodies,
                               std::size_t steps, std::int64_t differences) {
  nlohmann::ordered_json json = {{"asset", a.asset.string()},
                                 {"poses", a.poses.string()},
                                 {"bodies", bodies},
                                 {"steps", steps},
                                 {"continuous", a.steps.continuous},
                                 {"triangles", a.triangles},
                                 {"threads", nlohmann::ordered_json::array()}};
  for (const Crew& c : all) {
    json["threads"].push_back({{"threads", c.threads},
                               {"update_ms_per_step", c.update_ms},
                               {"search_ms_per_step", c.search_ms},
                               {"search_ratio", all.front().search_ms / c.search_ms}});
  }
  json["different_steps"] = differences;
  return json;
}

void print(const std::vector<Crew>& all, std::size_t bodies, std::size_t steps, std::int64_t differences) {
  std::cout << bodies << " bodies, " << steps << " steps, milliseconds of wall clock per step\n\n"
            << "threads     update     search    ratio    ratio of the sum\n";
  for (const Crew& c : all) {
    const Crew& one = all.front();
    std::cout << bench::format("%7d %10.4f %10.4f %8.3f %19.3f\n", c.threads, c.update_ms, c.search_ms,
                               one.search_ms / c.search_ms,
                               (one.update_ms + one.search_ms) / (c.update_ms + c.search_ms));
  }
  if (differences == 0) {
    std::cout << "\nThe same results in the same order.\n";
  } else {
    std::cerr << "encage-bench threads: results differ in " << differences << " steps\n";
  }
}

bool run(ThreadsArguments& a) {
  bench::check_outputs({a.json}, {a.asset, a.poses});
  bench::Watch watch;
  namespace tbb = oneapi::tbb;
  const auto most = static_cast<std::size_t>(*std::max_element(a.threads.begin(), a.threads.end()));
  const tbb::global_control enough_threads(tbb::global_control::max_allowed_parallelism, most);
  const ShapePtr shape = load_shape(a.asset);
  const std::vector<WorldStep> steps = make_steps(read_poses(a.poses), *shape, a.steps);
  std::vector<Crew> all = make_contestants(a, shape, steps);
  const std::int64_t differences = count_differences(all, steps);
  measure(all, steps, a.runs, watch);
  const std::size_t bodies = steps.front().size();
  if (!a.json.empty()) tool::write_json(a.json, to_json(a, all, bodies, steps.size(), differences));
  print(all, bodies, steps.size(), differences);
  return differences == 0;
}

}  // namespace

bench::Command command() {
  return bench::make_command<ThreadsArguments>(
      "threads", "Searches worlds of many bodies with one thread and with several: the same results, how fast?",
      examples, define, run);
}

}  // namespace encage::threads
