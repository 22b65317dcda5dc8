// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench queries: rays beside Embree, points beside CGAL, casts of volumes.

#include "bench/common/meshes.h"
#include "bench/common/report.h"
#include "bench/common/watch.h"
#include "bench/suite/commands.h"
#include "bench/suite/queries/compare.h"
#include "cagegen/cli/output_file.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

namespace encage::queries {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bench queries --asset octopus.glb --json queries.json

Rays at the asset's fine mesh, first hits one ray after the other, by Encage and by Embree. Some rays, a tenth of them
aimed at vertices, are compared with exact arithmetic on all triangles. Points by Encage and by CGAL's AABB tree. Spheres,
capsules and boxes that are cast by Encage alone.

Exit status: 0; 1 if Encage misses a hit, a distance is out of its bounds or a cast is late; 2 for bad input or
usage.)";

struct QueryArguments {
  std::filesystem::path asset, json;
  int rays = 200'000, points = 30'000, casts = 10'000, checks = 1'000, runs = 5;
};

void define(bench::CommandOptions& options, QueryArguments& a) {
  options.asset(a.asset, "Asset with its fine mesh").required();
  options.add("--rays", a.rays, "Rays that are timed").between(1, 100'000'000).shows_default().type("N");
  options.add("--points", a.points, "Points").between(1, 100'000'000).shows_default().type("N");
  options.add("--casts", a.casts, "Volumes that are cast").between(1, 100'000'000).shows_default().type("N");
  options.add("--checks", a.checks, "Rays that are checked").between(1, 100'000'000).shows_default().type("N");
  options.runs(a.runs, "Runs; the median counts");
  options.json(a.json);
}

nlohmann::ordered_json to_json(const std::vector<QueryRow>& rows) {
  auto json = nlohmann::ordered_json::array();
  for (const QueryRow& row : rows) {
    json.push_back(
        {{"name", row.name}, {"per_second", row.per_second}, {"checked", row.checked}, {"wrong", row.wrong}});
  }
  return json;
}

void print(const std::vector<QueryRow>& rows, const char* title, const char* wrong) {
  bench::MarkdownTable table(std::cout, {title, "million a second", "checked", wrong});
  for (const QueryRow& row : rows) {
    table.row({row.name, bench::format("%.3f", 1e-6 * row.per_second), std::to_string(row.checked),
               std::to_string(row.wrong)});
  }
  std::cout << '\n';
}

bool run(QueryArguments& a) {
  bench::check_outputs({a.json}, {a.asset});
  const ShapePtr shape = load_shape(a.asset);
  const TriangleMesh mesh = bench::fine_mesh(*shape, a.asset);
  bench::Watch watch;
  const std::vector<QueryRow> rays = compare_rays(*shape, mesh, a.rays, a.checks, a.runs, watch.reporter("rays"));
  const std::vector<QueryRow> points = compare_points(*shape, mesh, a.points, a.runs, watch.reporter("points"));
  const std::vector<QueryRow> casts = measure_casts(*shape, mesh, a.casts, a.runs, watch.reporter("casts"));
  if (!a.json.empty()) {
    tool::write_json(a.json, {{"asset", a.asset.string()},
                              {"runs", a.runs},
                              {"rays", to_json(rays)},
                              {"points", to_json(points)},
                              {"casts", to_json(casts)}});
  }
  print(rays, "rays, first hit", "missed");
  print(points, "points", "contradictions");
  print(casts, "casts", "contradictions");
  std::int64_t wrong = rays.front().wrong + points[0].wrong + points[1].wrong;
  for (const QueryRow& row : casts) wrong += row.wrong;
  if (wrong > 0) std::cerr << "encage-bench queries: " << wrong << " answers are wrong\n";
  return wrong == 0;
}

}  // namespace

bench::Command command() {
  return bench::make_command<QueryArguments>(
      "queries", "Measures rays beside Embree, nearest points beside CGAL, and casts, and checks the answers.",
      examples, define, run);
}

}  // namespace encage::queries
