// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench distance: how far apart bodies are, by cages, by the fine meshes, by FCL.

#include "bench/common/meshes.h"
#include "bench/common/report.h"
#include "bench/common/watch.h"
#include "bench/suite/commands.h"
#include "bench/suite/distance/compare.h"
#include "cagegen/cli/output_file.h"

#include <encage/error.h>

#include <nlohmann/json.hpp>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace encage::distances {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bench distance --asset octopus.glb --poses bouncing.csv --every 400 --json distance.json

All pairs of bodies in some steps, by their distance in parts of the body's diagonal. Cages give lower bounds; "half"
stops as soon as the bound is half the distance. FCL measures the asset's fine mesh, in double.

Exit status: 0; 1 if a bound is larger than the distance or FCL finds another one; 2 for bad input or usage.)";

struct DistanceArguments {
  std::filesystem::path asset, poses, json;
  std::int64_t every = 400;
  int pairs = 40, runs = 5;
};

void define(bench::CommandOptions& options, DistanceArguments& a) {
  options.asset(a.asset, "Asset of all bodies, with its fine mesh").required();
  options.poses(a.poses);
  options.every(a.every);
  options.add("--pairs", a.pairs, "Pairs of each class, at most").between(1, 1'000'000).shows_default().type("N");
  options.runs(a.runs, "Runs; the median time of each pair counts");
  options.json(a.json);
}

nlohmann::ordered_json to_json(const std::vector<ClassRows>& classes) {
  auto json = nlohmann::ordered_json::array();
  for (const ClassRows& one : classes) {
    auto rows = nlohmann::ordered_json::array();
    for (const DistanceRow& row : one.rows) {
      rows.push_back({{"name", row.name},
                      {"median_us", row.median_us},
                      {"mean_us", row.mean_us},
                      {"tightness", row.tightness},
                      {"wrong", row.wrong}});
    }
    json.push_back({{"class", one.name}, {"pairs", one.pairs}, {"rows", rows}});
  }
  return json;
}

/// A Markdown table: median microseconds, or tightness.
template <class Value>
void print(const std::vector<ClassRows>& classes, const char* title, const char* pattern, const Value& value) {
  bench::MarkdownTable::Cells head{title};
  for (const ClassRows& one : classes) head.push_back(one.name + " (" + std::to_string(one.pairs) + ")");
  bench::MarkdownTable table(std::cout, head);
  for (std::size_t r = 0; r < classes.front().rows.size(); ++r) {
    bench::MarkdownTable::Cells cells{classes.front().rows[r].name};
    for (const ClassRows& one : classes) cells.push_back(bench::format(pattern, value(one.rows[r])));
    table.row(cells);
  }
  std::cout << '\n';
}

bool run(DistanceArguments& a) {
  bench::check_outputs({a.json}, {a.asset, a.poses});
  const std::vector<PoseStep> poses = read_poses(a.poses);
  const ShapePtr shape = load_shape(a.asset);
  const TriangleMesh mesh = bench::fine_mesh(*shape, a.asset);
  const std::vector<PairClass> pairs =
      make_pairs(*shape, bounds(mesh).diagonal().norm(), poses, a.every, static_cast<std::size_t>(a.pairs));
  bench::Watch watch;
  const std::vector<ClassRows> classes = compare(*shape, mesh, pairs, a.runs, watch.reporter("measuring"));
  if (!a.json.empty()) {
    tool::write_json(a.json, {{"asset", a.asset.string()},
                              {"poses", a.poses.string()},
                              {"every", a.every},
                              {"runs", a.runs},
                              {"classes", to_json(classes)}});
  }
  print(classes, "median us of a pair", "%.1f", [](const DistanceRow& row) { return row.median_us; });
  print(classes, "mean us of a pair", "%.1f", [](const DistanceRow& row) { return row.mean_us; });
  print(classes, "bound / distance, median", "%.3f", [](const DistanceRow& row) { return row.tightness; });
  std::int64_t wrong = 0;
  for (const ClassRows& one : classes) {
    for (const DistanceRow& row : one.rows) wrong += row.wrong;
  }
  if (wrong > 0) std::cerr << "encage-bench distance: " << wrong << " answers contradict the bounds of the distance\n";
  return wrong == 0;
}

}  // namespace

bench::Command command() {
  return bench::make_command<DistanceArguments>(
      "distance", "Measures distances of bodies: bounds from cages, exact ones of the fine meshes, FCL's.", examples,
      define, run);
}

}  // namespace encage::distances
