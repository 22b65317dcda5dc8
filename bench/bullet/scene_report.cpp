// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/bullet/scene_report.h"

#include "bench/common/report.h"
#include "bench/common/statistics.h"

#include <algorithm>
#include <ostream>

namespace encage::bullet_bench {
namespace {

double median(const std::vector<SceneRun>& runs, double SceneRun::*figure) {
  std::vector<double> values;
  for (const SceneRun& run : runs) values.push_back(run.*figure);
  return bench::median(values);
}

struct Figure {
  const char* key;
  double SceneRun::*value;
};

constexpr Figure figures[] = {{"detect_ms", &SceneRun::detect_ms},
                              {"detect_ms_last_second", &SceneRun::last_detect_ms},
                              {"step_ms", &SceneRun::step_ms},
                              {"start_penetration", &SceneRun::start_penetration},
                              {"max_penetration", &SceneRun::max_penetration},
                              {"last_penetration", &SceneRun::last_penetration},
                              {"rms_linear", &SceneRun::rms_linear},
                              {"rms_angular", &SceneRun::rms_angular},
                              {"points_per_pair", &SceneRun::points_per_pair},
                              {"touching_pairs", &SceneRun::touching_pairs}};

}  // namespace

bool MethodRuns::holds() const {
  return std::all_of(runs.begin(), runs.end(), [](const SceneRun& run) { return run.verdict.holds; });
}

nlohmann::ordered_json to_json(const SceneResult& result) {
  nlohmann::ordered_json json;
  for (const MethodRuns& method : result.methods) {
    nlohmann::ordered_json& entry = json[method.method];
    for (const Figure& figure : figures) entry[figure.key] = median(method.runs, figure.value);
    entry["holds"] = method.holds();
    for (const nlohmann::ordered_json& details : method.details) {
      if (!details.is_null()) entry["shapes"].push_back(details);
    }
    for (const SceneRun& run : method.runs) {
      nlohmann::ordered_json& one = entry["runs"].emplace_back();
      one["seed"] = run.seed;
      for (const Figure& figure : figures) one[figure.key] = run.*figure.value;
      one["holds"] = run.verdict.holds;
      one["figure"] = run.verdict.value;
      one["outcome"] = run.verdict.figure;
      one["pose_hash"] = to_string(run.pose_hash);
    }
  }
  return json;
}

void print(std::ostream& out, const SceneResult& result) {
  std::string triangles;
  for (const std::int64_t count : result.triangles) {
    triangles += (triangles.empty() ? "" : " and ") + std::to_string(count);
  }
  out << "\n## " << result.scene << ": meshes of " << triangles << " triangles\n\n";
  bench::MarkdownTable table(out,
                             {"method", "detect ms", "last s", "step ms", "start mm", "max mm", "last mm", "rms m/s",
                              "rms rad/s", "points", "pairs", "holds"},
                             11, 9);
  for (const MethodRuns& method : result.methods) {
    const auto cell = [&](const char* pattern, double SceneRun::*value, double factor = 1) {
      return bench::format(pattern, factor * median(method.runs, value));
    };
    table.row({method.method, cell("%.3f", &SceneRun::detect_ms), cell("%.3f", &SceneRun::last_detect_ms),
               cell("%.3f", &SceneRun::step_ms), cell("%.2f", &SceneRun::start_penetration, 1e3),
               cell("%.2f", &SceneRun::max_penetration, 1e3), cell("%.2f", &SceneRun::last_penetration, 1e3),
               cell("%.4f", &SceneRun::rms_linear), cell("%.4f", &SceneRun::rms_angular),
               cell("%.1f", &SceneRun::points_per_pair), cell("%.1f", &SceneRun::touching_pairs),
               method.holds() ? "yes" : "no"});
  }
  out << '\n';
  for (const MethodRuns& method : result.methods) {
    for (const SceneRun& run : method.runs) {
      out << method.method << ", seed " << run.seed << ": " << (run.verdict.holds ? "holds" : "fails") << ": "
          << run.verdict.figure << "; poses " << to_string(run.pose_hash) << '\n';
    }
    for (const nlohmann::ordered_json& details : method.details) {
      if (details.is_null()) continue;
      const auto spread = [&](const char* key) {
        const nlohmann::ordered_json& figures = details[key];
        return bench::format("%.2f / %.2f / %.2f", figures["mean"].get<double>(), figures["p95"].get<double>(),
                             figures["max"].get<double>());
      };
      out << method.method << ": " << details["hulls"] << " hulls of " << details["triangles"]
          << " triangles; mean / 95 % / max in % of the radius: surface outside the body's by "
          << spread("outside_percent") << ", vertices of the body outside all hulls by " << spread("uncovered_percent")
          << '\n';
    }
  }
}

}  // namespace encage::bullet_bench
